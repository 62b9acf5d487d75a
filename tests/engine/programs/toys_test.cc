#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "engine/accuracy/reference.h"
#include "engine/motion/step_weight.h"
#include "engine/motion/system_entry.h"
#include "stiefel/conversion.h"
#include "stiefel/diagnosis.h"
#include "stiefel/error_estimate.h"
#include "stiefel/linearization.h"
#include "stiefel/tradeoff.h"
#include "tests/support/toys/toys.h"

// A system without frame and momentum that comes to rest, and two methods, which the library does
// not have: what docs/adding_a_system.md and docs/adding_a_method.md walk through.

namespace stiefel {
namespace {

using testing::toy_scene;
using testing::two_by_two;

Scene resolved(const SceneDescription& description) {
  auto scene = resolve_recommending(description);
  if (!scene) throw std::runtime_error(scene.error()[0].field + ": " + scene.error()[0].rule);
  return *std::move(scene);
}

/// max |H - H(t)| of a run from two_by_two(-1), D = diag(2, 1).
double error(const Simulation& now, double t) {
  return (now.get("H") - two_by_two(-1 + 2 * t)).cwiseAbs().maxCoeff();
}

SceneDescription larger() {
  SceneDescription d = system_entry("brockett")->example(1);
  d.system = "brockett";
  d.step = 0.02;
  return d;
}

TEST(Toys, StandInTheCatalogueAfterTheLibrarysOwn) {
  const SystemInfo& system = *catalogue().system("brockett");
  EXPECT_EQ(&system, &catalogue().systems.back());
  EXPECT_EQ(catalogue().methods.back().name, "heun");
  std::vector<std::string_view> methods;
  for (const auto& on : system.methods) methods.push_back(on.method);
  EXPECT_EQ(methods, (std::vector<std::string_view>{"rk4", "adaptive", "heun"}));
}

TEST(Toys, AreRefusedATangentByName) {
  const Scene scene = resolved(toy_scene("rk4"));
  const auto refused = Linearization::make(scene, {}, *make_simulation(scene));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().front().field, "system");
  EXPECT_TRUE(refused.error().front().rule.contains("rigid_body")) << refused.error().front().rule;
}

TEST(Toys, AWrongSceneIsRefusedByName) {
  auto d = toy_scene("huen");
  EXPECT_NE(Scene::resolve(d).error()[0].rule.find("did you mean heun?"), std::string::npos);
  d = toy_scene();
  d.initial["H"].values(0, 1) = 7;
  EXPECT_EQ(Scene::resolve(d).error()[0].field, "initial.H");
}

TEST(Toys, WithoutAMethodTheSceneGetsTheOneWithErrorControl) {
  const Scene scene = resolved(toy_scene());
  EXPECT_EQ(scene.method(), "adaptive");
  EXPECT_EQ(scene.tolerance(), catalogue().method("adaptive")->default_tolerance);
}

TEST(Toys, RunToRest) {
  const Scene scene = resolved(larger());
  const auto now = make_simulation(scene);
  ASSERT_TRUE(now->advance(10000).reached());
  Eigen::MatrixXd H = now->get("H");
  const Eigen::VectorXd diagonal = H.diagonal();
  H.diagonal().setZero();
  EXPECT_LT(H.cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_TRUE(std::is_sorted(diagonal.begin(), diagonal.end(), std::greater<>()));
  EXPECT_LT(now->rate(), 1e-9);
}

TEST(Toys, HeunIsOfOrderTwo) {
  const auto error_of_substeps = [](int m) {
    auto d = toy_scene("heun");
    d.method->substeps = m;
    const auto now = make_simulation(resolved(d));
    EXPECT_TRUE(now->advance(20).reached());
    return error(*now, 1);
  };
  EXPECT_NEAR(error_of_substeps(4) / error_of_substeps(8), 4, 0.2);
}

/// A body in N dimensions, in the symmetric representation.
SceneDescription turning(int N, const char* method, double step) {
  SceneDescription d;
  d.system = "symmetric_rigid_body";
  d.method = MethodDescription{method, {}, {}, "", {}};
  RowMatrix M = RowMatrix::Zero(N, N);
  for (int i = 0; i < N; ++i) {
    d.inertia.push_back(1 + i);
    for (int j = 0; j < i; ++j) M(j, i) = -(M(i, j) = 1 + i - 0.4 * j * j);
  }
  d.initial["Q"] = RowMatrix::Identity(N, N);
  d.initial["M"] = M;
  d.step = step;
  return d;
}

TEST(Toys, LieMidpointIsOfOrderTwo) {
  const auto at_1 = [](int N, const char* method, int steps) {
    const auto now = make_simulation(resolved(turning(N, method, 1.0 / steps)));
    EXPECT_TRUE(now->advance(steps).reached());
    return now->get("Q");
  };
  for (const int N : {3, 4, 5}) {
    const Eigen::MatrixXd exact = at_1(N, "munthe_kaas4", 2048);
    const double coarse = (at_1(N, "lie_midpoint", 128) - exact).cwiseAbs().maxCoeff();
    const double fine = (at_1(N, "lie_midpoint", 256) - exact).cwiseAbs().maxCoeff();
    EXPECT_NEAR(coarse / fine, 4, 0.2) << N;
  }
}

TEST(Toys, LieMidpointKeepsWhatItDeclares) {
  const Scene scene = resolved(turning(4, "lie_midpoint", 0.02));
  const auto now = make_simulation(scene);
  ASSERT_TRUE(now->advance(1000).reached());
  int kept = 0;
  for (const InvariantDrift& invariant : diagnose(scene, *now).invariants) {
    const bool exact = invariant.conservation == Conservation::exact;
    EXPECT_LT(invariant.drift(), exact ? 1e-13 : 1) << invariant.name;
    kept += exact;
    if (invariant.name == "energy") {
      EXPECT_GT(invariant.drift(), 1e-9);
    }
  }
  EXPECT_GT(kept, 6);
}

TEST(Toys, AFieldThatTheSceneHasNotIsNamed) {
  const auto now = make_simulation(resolved(toy_scene()));
  EXPECT_THROW(now->get("P"), std::invalid_argument);
}

TEST(Toys, AreDiagnosed) {
  const Scene scene = resolved(toy_scene("heun"));
  const auto now = make_simulation(scene);
  ASSERT_TRUE(now->advance(100).reached());
  const Diagnosis diagnosis = diagnose(scene, *now);
  ASSERT_EQ(diagnosis.invariants.size(), 2u);
  EXPECT_EQ(diagnosis.invariants[1].name, "eigenvalues[2]");
  EXPECT_EQ(diagnosis.invariants[1].conservation, Conservation::drifts);
  EXPECT_GT(diagnosis.invariants[1].drift(), 1e-6);
  EXPECT_LT(diagnosis.invariants[1].drift(), 1e-2);
  EXPECT_FALSE(diagnosis.orthogonality);
  EXPECT_FALSE(symplectic_defect(scene, *now, 1, 1, {}).has_value());
}

TEST(Toys, WithoutAReferenceTheRefusalSaysSo) {
  auto d = toy_scene("rk4");
  const Scene scene = resolved(d);
  const auto now = make_simulation(scene);
  EXPECT_EQ(estimate_error(scene, *now, 1e9, {}).missing, "there is no reference for brockett");
  auto tradeoff = Tradeoff::prepare({.scene = d, .horizon = 2});
  ASSERT_TRUE(tradeoff);
  EXPECT_EQ((*tradeoff)->solve_reference({}).error()[0].field, "scene.system");
  d.method.reset();
  d.tolerance = 1e-6;
  d.horizon = 1;
  EXPECT_NE(resolve_choosing(d).error()[0].rule.find("has no reference"), std::string::npos);
}

TEST(Toys, AMissingWeightIsEstimatedWithAWarning) {
  const Scene scene = resolved(toy_scene("heun"));
  EXPECT_FALSE(is_weighed(scene));
  EXPECT_GT(step_weight(scene), 100);
  ASSERT_EQ(warnings(scene).size(), 1u);
  EXPECT_NE(warnings(scene)[0].find("the work of a step of heun on brockett is estimated"),
            std::string::npos);
}

}  // namespace
}  // namespace stiefel
