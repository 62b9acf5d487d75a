// What a conversion refuses, and by which path of the request it names it.
#include <gtest/gtest.h>

#include "stiefel/catalogue.h"
#include "stiefel/conversion.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::RandomBody;

Scene body(double step = 0.1) {
  return Scene::resolve(testing::description(RandomBody(4, 1), step, "rk4")).value();
}

Scene geodesic_on(int n, int N) {
  SceneDescription d;
  const testing::RandomFrame<double> frame(n, N, 1, 3);
  d.system = "stiefel";
  d.method = MethodDescription{"rk4", {}, {}, ""};
  d.step = 0.1;
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  d.initial["Q"] = Eigen::MatrixXd(frame.Q);
  d.initial["S"] = Eigen::MatrixXd(frame.S);
  return Scene::resolve(d).value();
}

/// Returns the refusal's path, and expects it to be of an argument outside its domain.
std::string outside(const Scene& scene, const ConversionTarget& target) {
  const auto refused = convert(scene, target);
  if (refused || !std::holds_alternative<OutsideDomain>(refused.error())) return "not refused";
  return std::get<OutsideDomain>(refused.error()).field;
}

std::string violated(const Scene& scene, const ConversionTarget& target) {
  const auto refused = convert(scene, target);
  if (refused || !std::holds_alternative<Violations>(refused.error())) return "not refused";
  return std::get<Violations>(refused.error()).front().field;
}

TEST(ConversionRefusal, NamesTheArgumentOutsideTheDomain) {
  const double norm = 5 / body().M().norm();
  for (const char* system :
       {"symmetric_rigid_body", "right_symmetric_rigid_body", "reduced_rigid_body",
        "symmetric_moser_veselov", "parametric_rigid_body", "parametric_moser_veselov"})
    EXPECT_EQ(outside(body(), {system, 10 * norm}), "epsilon") << system;
  for (const char* system : {"moser_veselov_pair", "discrete_stiefel", "interpolation"})
    EXPECT_EQ(outside(body(1e3), {system}), "scene.step") << system;
  EXPECT_EQ(outside(geodesic_on(2, 5), {"ellipsoid"}), "to");
  EXPECT_EQ(outside(geodesic_on(2, 5), {"discrete_stiefel"}), "to");
  const Scene two_frames =
      Scene::resolve(testing::any_scene("discrete_stiefel", "", 1, 0.1)).value();
  ASSERT_LT(two_frames.Q().rows(), two_frames.Q().cols());
  EXPECT_EQ(outside(two_frames, {"stiefel"}), "scene.initial.Q");
}

TEST(ConversionRefusal, RefusesANumberThatTheTargetDoesNotHave) {
  for (const SystemInfo& system : catalogue().systems) {
    const bool parametric = system.name.starts_with("parametric");
    const bool scaled = parametric || system.name == "reduced_rigid_body" ||
                        system.name.find("symmetric") != std::string_view::npos;
    const std::string name(system.name);
    if (!scaled) {
      EXPECT_EQ(violated(body(), {name, 0.1}), "epsilon") << name;
    }
    if (!parametric) {
      EXPECT_EQ(violated(body(), {name, {}, 0.1}), "parameter") << name;
    }
  }
  for (const char* name : other_targets) {
    EXPECT_EQ(violated(body(), {name, 0.1}), "epsilon") << name;
    EXPECT_EQ(violated(body(), {name, {}, 0.1}), "parameter") << name;
  }
  EXPECT_TRUE(convert(body(), {"parametric_rigid_body", 0.1, 0.1}));
  EXPECT_TRUE(convert(body(), {"symmetric_rigid_body", 0.1}));
}

/// mu of the scene to be converted is no number of the request's own.
TEST(ConversionRefusal, TakesTheParameterOfTheSceneAlong) {
  const Scene with = convert(body(), {"parametric_rigid_body", {}, 0.1})->scene.value();
  EXPECT_TRUE(convert(with, {"rigid_body"}));
  EXPECT_EQ(convert(with, {"parametric_moser_veselov"})->scene->parameter(), 0.1);
}

}  // namespace
}  // namespace stiefel
