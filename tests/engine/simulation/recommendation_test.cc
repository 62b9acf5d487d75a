#include "engine/motion/recommendation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stiefel/catalogue.h"
#include "stiefel/conversion.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/surveys/recommendation_survey.h"

namespace stiefel {
namespace {

using testing::RandomBody;

std::vector<std::string> continuous_systems() {
  std::vector<std::string> names;
  for (const auto& system : catalogue().systems)
    if (!system.discrete) names.emplace_back(system.name);
  return names;
}

SceneDescription body(int N, double step, double spread = 4) {
  SceneDescription d = testing::description(RandomBody(N, 1, spread), step, "rk4");
  d.method.reset();
  return d;
}

MethodDescription method_of(const SceneDescription& description) {
  return *resolve_recommending(description).value().description().method;
}

class RecommendedMethod : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, RecommendedMethod, ::testing::ValuesIn(continuous_systems()),
                         [](const auto& which) { return which.param; });

/// The first seeds of the long survey, in small dimensions.
TEST_P(RecommendedMethod, IsAccurateAndCheap) {
  const std::string& system = GetParam();
  const bool slow = system.find("rigid_body") == std::string::npos && system != "mclachlan_scovel";
  for (unsigned seed = 1; seed <= (slow ? 3 : 8); ++seed) {
    const auto outcome =
        testing::survey_recommendation(testing::scene_without_method(system, seed, slow ? 3 : 5));
    SCOPED_TRACE(std::to_string(seed) + ": " + outcome.scene + ", " + outcome.method +
                 ", against " + outcome.cheapest);
    EXPECT_LE(outcome.error, 1e-8 * outcome.condition);
    EXPECT_LE(outcome.cost, testing::most_cost(outcome));
  }
}

void expect_accurate(const std::string& system, testing::Hard kind, int largest_N) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    const auto outcome =
        testing::survey_hard_scene(testing::hard_scene(system, kind, seed, largest_N));
    EXPECT_LE(outcome.error, 1e-8 * outcome.condition)
        << static_cast<int>(kind) << " " << seed << " " << outcome.scene << ", " << outcome.method;
  }
}

/// Nearly equal λ, Λ over 1:10⁴, and next to an unstable rotation, relative to the condition. Next
/// to an unstable rotation the errors of `adaptive` are up to 20 times larger.
TEST(Recommendation, IsAccurateAtHardPlaces) {
  for (const char* system : {"rigid_body", "right_rigid_body", "symmetric_rigid_body"}) {
    expect_accurate(system, testing::Hard::nearly_equal, 5);
    expect_accurate(system, testing::Hard::wide, 5);
  }
  expect_accurate("rigid_body", testing::Hard::next_to_equilibrium, 4);
}

/// A chaotic geodesic with h‖Ω‖ = 0.27 and the condition 5e6, for which a single stride a step is
/// enough: two substeps with three strides in all are still cheap.
TEST(Recommendation, IsCheapForAFastChaoticGeodesic) {
  const auto outcome =
      testing::survey_recommendation(testing::scene_without_method("stiefel", 18, 16));
  EXPECT_GT(outcome.condition, 1e6);
  EXPECT_LE(outcome.error, 1e-8 * outcome.condition);
  EXPECT_LE(outcome.cost, 3) << outcome.scene << ", " << outcome.method;
}

/// A geodesic with a condition of 100 to 250.
TEST(Recommendation, IsAccurateForAWellConditionedGeodesic) {
  const auto outcome =
      testing::survey_recommendation(testing::scene_without_method("stiefel", 94, 16));
  EXPECT_LT(outcome.condition, 250);
  EXPECT_LE(outcome.error, 1e-8 * outcome.condition) << outcome.scene << ", " << outcome.method;
  EXPECT_LE(outcome.cost, 3);
}

/// A geodesic on V(n, N) with S = QUΛ, U skew, from the frame of the first n unit vectors turned by
/// seeded rotations; row and column 0 of U are `fast` times larger.
SceneDescription geodesic(int n, const std::vector<double>& inertia, unsigned seed,
                          double fast = 1) {
  const auto N = static_cast<int>(inertia.size());
  const RandomBody body(N, seed);
  const Eigen::Map<const Eigen::VectorXd> lambda(inertia.data(), N);
  Eigen::MatrixXd U = body.M / body.M.norm();
  U.row(0) *= fast;
  U.col(0) *= fast;
  const RowMatrix Q = body.Q.topRows(n), S = Q * U * lambda.asDiagonal();
  SceneDescription d;
  d.system = "stiefel";
  d.inertia = inertia;
  d.initial = {{"Q", Q}, {"S", S}};
  d.step = 0.15 / (Q * U).norm();
  return d;
}

/// λ over 1:10⁴, nearly equal, and one fast row: every state is on the manifold to rounding.
TEST(Recommendation, OnFramesStaysOnTheManifold) {
  SceneDescription wide = geodesic(2, {0.01, 1, 100}, 1);
  wide.initial = {{"Q", RowMatrix(RowMatrix::Identity(2, 3))},
                  {"S", RowMatrix(RowMatrix::Zero(2, 3))}};
  wide.initial["S"].values << 0, 1, 25, -0.01, 0, -50;
  wide.step = 0.0625;
  std::vector<SceneDescription> scenes = {wide};
  for (const int n : {1, 2, 3}) {
    scenes.push_back(geodesic(n, {1, 10, 100, 1000, 1e4}, 2));
    scenes.push_back(geodesic(n, {1, 1.000001, 0.999999, 1.00001}, 3));
    scenes.push_back(geodesic(n, {1, 2, 3, 4, 5}, 4, 1e3));
  }
  for (const SceneDescription& description : scenes) {
    const Scene scene = resolve_recommending(description).value();
    const auto now = make_simulation(scene);
    ASSERT_TRUE(now->advance(100).reached()) << scene.method();
    const Eigen::MatrixXd Q = now->get("Q"), V = now->get("Qdot"), along = Q * V.transpose();
    EXPECT_LE(now->orthogonality().value(), 2e-15);
    EXPECT_LE((along + along.transpose()).cwiseAbs().maxCoeff(), 2e-15 * V.norm());
  }
}

TEST(Recommendation, IsAccurateForNearlyEqualInertia) {
  for (const double apart : {1e-2, 1e-5, 1e-8}) {
    const auto outcome =
        testing::survey_recommendation(geodesic(2, {1, 1 + apart, 1 - apart, 1 + 2 * apart}, 5));
    EXPECT_LE(outcome.error, 1e-8 * outcome.condition) << outcome.scene << ", " << outcome.method;
  }
}

/// Every recommended method is one of the system's and accepts every scene for which it is
/// recommended.
TEST_P(RecommendedMethod, IsOneOfTheSystemAndTheLastTakesEveryScene) {
  const SystemInfo& system = *catalogue().system(GetParam());
  const auto all = recommended(GetParam());
  ASSERT_FALSE(all.empty());
  for (const auto& one : all) {
    EXPECT_EQ(std::ranges::count(system.methods, one.method, &MethodOnSystem::method), 1);
    EXPECT_EQ(one.where.empty(), one.takes == nullptr);
    EXPECT_EQ(one.tolerance > 0, one.method == "adaptive");
  }
  EXPECT_TRUE(all.back().takes == nullptr);
}

/// h‖Ω‖ = 20: no solver stalls.
TEST_P(RecommendedMethod, ReachesTheEndOfALongStep) {
  auto given = testing::scene_without_method(GetParam(), 5, 4);
  const double rate = make_simulation(resolve_recommending(given).value())->rate();
  given.step = 20 / rate;
  const auto simulation = make_simulation(resolve_recommending(given).value());
  EXPECT_TRUE(simulation->advance(5).reached());
}

TEST(Recommendation, DependsOnTheShape) {
  EXPECT_EQ(method_of(body(3, 0.1)).name, "exact");
  EXPECT_EQ(method_of(body(4, 0.1)).name, "variational");
  EXPECT_EQ(method_of(body(5, 0.1)).name, "adaptive");
  auto two_valued = body(5, 0.1);
  two_valued.inertia = {1, 2, 2, 1, 1};
  EXPECT_EQ(method_of(two_valued).name, "exact");
}

TEST(Recommendation, InThreeDimensionsIsTheClosedForm) {
  for (const char* system :
       {"rigid_body", "right_rigid_body", "symmetric_rigid_body", "right_symmetric_rigid_body",
        "reduced_rigid_body", "mclachlan_scovel"}) {
    auto given = body(3, 0.1);
    given.system = system;
    EXPECT_EQ(method_of(given).name, "exact") << system;
  }
}

/// An ensemble advances in lanes, unless a member is next to the separatrix.
TEST(Recommendation, OfAnEnsembleInThreeDimensionsDependsOnTheSeparatrix) {
  SceneDescription given;
  given.system = "rigid_body";
  given.step = 0.05;
  given.members = 2;
  given.body.emplace();
  given.body->moments = {1, 2, 3};
  for (const double epsilon : {1e-1, 1e-2, 1e-5, 1e-9, 0.0}) {
    given.body->angular_velocity = {1, 1, 1, epsilon, 1, epsilon};
    EXPECT_EQ(method_of(given).name, epsilon > 1e-3 ? "preprocessed_variational" : "exact")
        << epsilon;
  }
}

/// Moments that no rigid body has: the body turns up to 50 times faster than at the start.
TEST(Recommendation, InLanesFollowsTheLargestRateOfTheMotion) {
  SceneDescription given;
  given.system = "rigid_body";
  given.step = 0.01;
  given.members = 1;
  given.body.emplace();
  given.body->angular_velocity = {1, 2, 3};
  for (const double ratio : {1.0, 10.0, 50.0, 100.0}) {
    given.body->moments = {1.11, ratio * 1.0011, 1.01};
    const Scene lanes = resolve_recommending(given).value();
    EXPECT_EQ(lanes.method(), "preprocessed_variational");
    auto alone = given;
    alone.members.reset();
    alone.method = MethodDescription{"exact", {}, {}, ""};
    const auto now = make_simulation(lanes), exact = make_simulation(Scene::resolve(alone).value());
    ASSERT_TRUE(now->advance(1000).reached() && exact->advance(1000).reached()) << ratio;
    for (const char* name : {"Q", "M"})
      EXPECT_LE((now->get(name) - exact->get(name)).cwiseAbs().maxCoeff(),
                1e-8 * exact->get(name).cwiseAbs().maxCoeff())
          << ratio << " " << name;
  }
}

/// Scene::resolve chooses no method. resolve_recommending keeps one that is given, and is
/// Scene::resolve for a discrete system.
TEST(Recommendation, IsForScenesWithoutAMethodAlone) {
  auto given = body(3, 0.1);
  const auto refused = Scene::resolve(given);
  ASSERT_FALSE(refused);
  ASSERT_EQ(refused.error().size(), 1u);
  EXPECT_EQ(refused.error().front().field, "method");
  EXPECT_EQ(refused.error().front().reason, "METHOD_NOT_CHOSEN");
  given.members = 1;
  EXPECT_EQ(Scene::resolve(given).error().front().reason, "METHOD_NOT_CHOSEN");
  EXPECT_EQ(method_of(given).name, "preprocessed_variational");
  given.method = MethodDescription{"rk4", {}, {}, ""};
  EXPECT_EQ(method_of(given).name, "rk4");
  given.method.reset();
  given.tolerance = 1e-6;
  given.horizon = 1;
  EXPECT_EQ(resolve_recommending(given).error().front().reason, "METHOD_NOT_CHOSEN");
  const auto discrete = resolve_recommending(testing::any_scene("moser_veselov", "", 1, 0.1));
  EXPECT_FALSE(discrete.value().description().method);
  EXPECT_EQ(discrete.value().tolerance(), 0);
}

TEST(Recommendation, SubstepsFollowFromTheStep) {
  EXPECT_EQ(method_of(body(3, -2)).substeps, 1);
  // ‖Ω‖ = 1, and 0.15 is the largest h‖Ω‖ of a substep in four dimensions.
  EXPECT_EQ(method_of(body(4, 0.14)).substeps, 1);
  EXPECT_EQ(method_of(body(4, 0.16)).substeps, 2);
  EXPECT_EQ(method_of(body(4, -1)).substeps, 7);
  auto at_rest = body(4, 1);
  at_rest.initial["M"] = RowMatrix(RowMatrix::Zero(4, 4));
  EXPECT_EQ(method_of(at_rest).substeps, 1);
  at_rest.initial.erase("Q");
  EXPECT_EQ(method_of(at_rest).substeps, 1);
}

TEST(Recommendation, DoesNotDependOnUnits) {
  for (const bool momentum_only : {false, true}) {
    auto metres = body(4, 0.2);
    if (momentum_only) metres.initial.erase("Q");
    auto other = metres;
    for (double& l : other.inertia) l *= 1e100;
    other.initial["M"].values *= 1e140;
    other.step = 1e-40 * *other.step;
    EXPECT_EQ(method_of(metres).substeps, method_of(other).substeps);
  }
}

TEST(Recommendation, IsAccurateInLongSteps) {
  for (const int N : {3, 4, 5}) {
    auto given = body(N, 2.5, 30);
    const auto outcome = testing::survey_recommendation(given);
    EXPECT_LE(outcome.error, 1e-8) << outcome.scene << " " << outcome.method;
  }
}

/// An ensemble takes the first that is for all of its members, and substeps enough for the fastest.
TEST(Recommendation, OfAnEnsembleIsForAllMembers) {
  auto slow = body(5, 0.4);
  SceneDescription both = slow;
  both.members = 2;
  RowMatrix Q(10, 5), M(10, 5);
  Q << slow.initial["Q"].values, slow.initial["Q"].values;
  M << slow.initial["M"].values, 3 * slow.initial["M"].values;
  both.initial = {{"Q", Q}, {"M", M}};
  auto fast = slow;
  fast.initial["M"].values *= 3;
  EXPECT_EQ(method_of(both).substeps, method_of(fast).substeps);
  EXPECT_LT(method_of(slow).substeps, method_of(fast).substeps);

  both.inertia = {1, 2, 2, 2, 2, 1, 2, 3, 4, 5};  // the first alone would take `exact`
  EXPECT_EQ(method_of(both).name, "adaptive");
  const Scene ensemble = resolve_recommending(both).value();
  for (const Scene& member : ensemble.members().range(0, ensemble.members().size()))
    EXPECT_EQ(member.method(), "adaptive");
}

TEST(Recommendation, IsTakenByAConversionToWhatHasNotTheMethod) {
  const Scene body_4d =
      Scene::resolve(testing::any_scene("rigid_body", "implicit_midpoint", 1, 0.1)).value();
  const auto pair = convert(body_4d, {"symmetric_rigid_body"}).value().scene.value();
  EXPECT_EQ(pair.method(), "adaptive");
  EXPECT_EQ(pair.tolerance(), recommended("symmetric_rigid_body").back().tolerance);
  EXPECT_EQ(convert(body_4d, {"right_rigid_body"}).value().scene->method(), "implicit_midpoint");
}

}  // namespace
}  // namespace stiefel
