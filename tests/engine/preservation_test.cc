#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/linalg/orthogonal.h"
#include "engine/simulation/diagnosis.h"
#include "tests/support/random_scene.h"

namespace stiefel {
namespace {

constexpr int scenes = 32;

/// The worst drift of each family of invariants over seeded scenes, at `steps`.
std::map<std::string, double> worst_drift(int N, const std::string& method, std::int64_t steps) {
  std::map<std::string, double> worst;
  for (unsigned seed = 1; seed <= scenes; ++seed) {
    const Scene scene = testing::random_scene(N, seed, 0.1, method);
    const auto simulation = make_simulation(scene);
    EXPECT_TRUE(simulation->advance(steps).reached());
    const Diagnosis diagnosis = diagnose(scene, *simulation);
    for (const auto& invariant : diagnosis.invariants) {
      double& w = worst[invariant.name.substr(0, invariant.name.find('['))];
      w = std::max(w, invariant.drift());
    }
    worst["orthogonality"] = std::max(worst["orthogonality"], *diagnosis.orthogonality);
  }
  return worst;
}

/// What the catalogue declares is what happens, from both sides: `exact` stays at rounding level
/// over ten times the steps, `drifts` really grows.
class Declared : public ::testing::TestWithParam<int> {};

TEST_P(Declared, IsMeasured) {
  const int N = GetParam();
  for (const char* name_of_system : {"rigid_body", "moser_veselov"}) {
    const auto& system = *catalogue().system(name_of_system);
    for (const auto& method : system.methods) {
      auto early = worst_drift(N, std::string(method.method), 300);
      auto late = worst_drift(N, std::string(method.method), 3000);
      for (const auto& [invariant, kept] : method.preserves) {
        const std::string name(invariant);
        const auto where = ::testing::Message()
                           << system.name << " " << method.method << " " << name << " N=" << N
                           << ": " << early[name] << " -> " << late[name];
        if (kept == Kept::exact) {
          EXPECT_LE(late[name], 1e-12) << where;
        } else if (kept == Kept::drifts) {
          EXPECT_GE(late[name], 3 * early[name]) << where;
          EXPECT_GE(late[name], 1e-9) << where;
        } else {
          EXPECT_LE(late[name], 2 * early[name]) << where;
        }
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Dimensions, Declared, ::testing::Values(3, 4));

TEST(Reversibility, IsMeasuredAsDeclared) {
  for (const auto& method : catalogue().methods)
    for (const int N : {3, 5}) {
      const testing::RandomBody body(N, 9);
      const auto name = std::string(method.name);
      const Scene there = Scene::resolve(testing::description(body, 0.1, name)).value();
      const auto out = make_simulation(there);
      ASSERT_TRUE(out->advance(100).reached());
      testing::RandomBody turned = body;
      turned.Q = out->get("Q");
      turned.M = out->get("M");
      SceneDescription back = testing::description(turned, -0.1, name);
      if (orthogonality_defect(turned.Q) > Scene::frame_tolerance) continue;
      const auto home = make_simulation(Scene::resolve(back).value());
      ASSERT_TRUE(home->advance(100).reached());
      const double error = (home->get("M") - body.M).norm();
      if (method.reversible)
        EXPECT_LT(error, 1e-12) << name;
      else
        EXPECT_GT(error, 1e-9) << name;
    }
}

}  // namespace
}  // namespace stiefel
