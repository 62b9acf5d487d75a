#include <gtest/gtest.h>

#include <cmath>

#include "stiefel/catalogue.h"
#include "stiefel/diagnosis.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

constexpr double float_rounding = 0x1p-24;  // of a float

struct Entry {
  SceneDescription scene;
  std::string text;
};

SceneDescription with_scalar(SceneDescription scene, const char* scalar) {
  scene.method->scalar = scalar;
  return scene;
}

/// Every method and order that is offered in float.
std::vector<Entry> offered(const std::string& arithmetic) {
  std::vector<Entry> all;
  for (const auto& system : catalogue().systems)
    for (const auto& on : system.methods) {
      if (!on.in_float) continue;
      for (const int order : catalogue().method(on.method)->orders) {
        const std::string method(on.method);
        SceneDescription scene = testing::description(testing::RandomBody(3, 1), 0.1, method);
        scene.method = MethodDescription{method, order, 1, arithmetic, {}, "float"};
        all.push_back(
            {scene, std::string(system.name) + " " + method + " " + std::to_string(order)});
      }
    }
  return all;
}

std::unique_ptr<Simulation> made(const SceneDescription& scene) {
  return make_simulation(Scene::resolve(scene).value());
}

double distance(const Simulation& a, const Simulation& b) {
  double largest = 0;
  for (std::size_t k = 0; k < a.block_count(); ++k) {
    const auto& name = a.fields()[k].name;
    largest = std::max(largest, (a.get(name) - b.get(name)).cwiseAbs().maxCoeff());
  }
  return largest;
}

TEST(InFloat, IsOfferedForBodies) { EXPECT_EQ(offered("plain").size(), 12u); }

/// Float and double differ by the rounding of 24 bits, and by no less.
TEST(InFloat, IsTheSameMapToItsRounding) {
  for (const char* arithmetic : {"plain", "compensated"})
    for (const auto& [scene, text] : offered(arithmetic)) {
      constexpr int steps = 200;
      const auto single = made(scene), twice = made(with_scalar(scene, "double"));
      ASSERT_TRUE(single->advance(steps).reached()) << text;
      ASSERT_TRUE(twice->advance(steps).reached()) << text;
      const double apart = distance(*single, *twice);
      EXPECT_LT(apart, 100 * float_rounding * (*arithmetic == 'p' ? steps : std::sqrt(steps)))
          << text << " " << arithmetic;
      EXPECT_GT(apart, float_rounding / 4) << text << " " << arithmetic;
    }
}

/// In compensated arithmetic the invariants that the map keeps exactly perform a random walk.
TEST(InFloat, CompensatedArithmeticKeepsInvariantsForLong) {
  constexpr int steps = 10'000;
  for (const auto& [scene, text] : offered("compensated")) {
    const auto single = made(scene);
    ASSERT_TRUE(single->advance(steps).reached()) << text;
    const auto diagnosis = diagnose(Scene::resolve(scene).value(), *single);
    for (const auto& invariant : diagnosis.invariants) {
      if (invariant.conservation != Conservation::exact) continue;
      EXPECT_LT(invariant.drift(), 10 * float_rounding * std::sqrt(steps))
          << text << " " << invariant.name;
    }
  }
}

TEST(InFloat, EndsWhereTheBranchDoes) {
  SceneDescription scene = testing::description(testing::RandomBody(3, 1), 3, "variational");
  const RunStatus in_double = made(scene)->advance(1);
  const RunStatus status = made(with_scalar(scene, "float"))->advance(1);
  EXPECT_EQ(status.outcome, Outcome::left_domain);
  EXPECT_NEAR(status.largest_step.value(), in_double.largest_step.value(), 0.01);
}

TEST(InFloat, IsRefusedWithARuleWhereItIsNot) {
  const auto rule = [](SceneDescription scene, const char* scalar) {
    const auto resolved = Scene::resolve(with_scalar(std::move(scene), scalar));
    return resolved ? "" : resolved.error().front().field + " " + resolved.error().front().rule;
  };
  const SceneDescription body = testing::description(testing::RandomBody(3, 1), 0.1, "variational");
  EXPECT_EQ(rule(body, "float"), "");
  EXPECT_EQ(rule(body, "half"), "method.scalar must be double or float");
  const std::string is_for =
      "method.scalar must be double: float is for N = 3 of rigid_body by variational, "
      "preprocessed_variational, rk4";
  SceneDescription exact = body;
  exact.method = MethodDescription{"exact", {}, {}, ""};
  EXPECT_EQ(rule(exact, "float"), is_for);
  EXPECT_EQ(rule(testing::description(testing::RandomBody(4, 1), 0.1, "rk4"), "float"), is_for);
  EXPECT_EQ(rule(testing::any_scene("stiefel", "rk4", 1, 0.1), "float"), is_for);
  SceneDescription far = body;
  far.step = 1e20;
  EXPECT_NE(rule(far, "float").find("step |step| must be 1e-18 to 1e+18"), std::string::npos);
  far.step = 1e15;  // of a step beyond 2^52 radians no digit of the angle is left
  EXPECT_EQ(rule(far, "double"), "");
}

}  // namespace
}  // namespace stiefel
