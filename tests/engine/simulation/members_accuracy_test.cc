// The choice for a tolerance and the trade-off, of ensembles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/accuracy/candidates.h"
#include "engine/accuracy/measurement.h"
#include "stiefel/catalogue.h"
#include "stiefel/tradeoff.h"
#include "tests/support/exact_motion.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/surveys/measured_tradeoff.h"

namespace stiefel {
namespace {

using testing::ensemble_of;
using testing::measured_tradeoff;
using testing::RandomBody;

/// Bodies of ‖Ω‖ = 0.2 … 1 in that order, so that the last is the fastest.
std::vector<RandomBody> bodies(int count, int N) {
  std::vector<RandomBody> all;
  for (int b = 0; b < count; ++b) {
    all.emplace_back(N, static_cast<unsigned>(b + 31));
    all.back().M *= 0.2 + 0.8 * (b + 1) / count;
  }
  return all;
}

std::vector<SceneDescription> scenes_of(const std::vector<RandomBody>& bodies, double step) {
  std::vector<SceneDescription> all;
  for (const RandomBody& body : bodies) {
    all.push_back(testing::description(body, step, "rk4"));
    all.back().method.reset();
  }
  return all;
}

SceneDescription asked(const std::vector<SceneDescription>& scenes, double tolerance,
                       double horizon) {
  SceneDescription d = ensemble_of(scenes);
  d.tolerance = tolerance;
  d.horizon = horizon;
  return d;
}

/// Against Boost.odeint in extended precision, which shares no code with the references.
double error_of_body(const RandomBody& body, const Simulation& now, double time) {
  const auto exact = testing::exact_motion(body.lambda, body.Q, body.M, time);
  return std::max((now.get("Q") - exact.Q).cwiseAbs().maxCoeff(),
                  (now.get("M") - exact.M).cwiseAbs().maxCoeff() / exact.M.cwiseAbs().maxCoeff());
}

TEST(ChoiceForMembers, HoldsTheToleranceInEach) {
  for (const auto& [N, count, tolerance] :
       {std::tuple{3, 12, 1e-6}, {3, 5, 1e-11}, {4, 6, 1e-4}, {5, 3, 1e-9}}) {
    const auto all = bodies(count, N);
    const auto [scene, chosen] =
        resolve_choosing(asked(scenes_of(all, 0.25), tolerance, 10)).value();
    ASSERT_EQ(scene.members().size(), all.size());
    const std::string& choice = chosen->reason;
    EXPECT_NE(choice.find(std::to_string(count) + " members"), std::string::npos) << choice;
    double worst = 0;
    for (std::size_t b = 0; b < all.size(); ++b) {
      const Scene& member = scene.members()[b];
      EXPECT_EQ(member.method(), scene.method());
      EXPECT_EQ(member.substeps(), scene.substeps());
      const auto now = make_simulation(member);
      ASSERT_TRUE(now->advance(40).reached());
      const double error = error_of_body(all[b], *now, 10);
      EXPECT_LE(error, tolerance) << "member " << b << ": " << choice;
      worst = std::max(worst, error);
    }
    // Not far better than asked, but in three dimensions, where high orders cost no more.
    EXPECT_TRUE(N == 3 || worst > 1e-4 * tolerance) << choice;
  }
}

/// The slower member has the larger error: it turns about the middle axis, and the fastest about
/// the axis of the largest moment, where nothing happens.
TEST(ChoiceForMembers, IsByTheMemberWithTheLargestError) {
  SceneDescription d;
  d.system = "rigid_body";
  d.step = 0.25;
  d.members = 2;
  d.body = BodyDescription{{}, {1, 2, 3}, {}, {0, 0, 1.5, 0.05, 1.2, 0.05}};
  d.tolerance = 1e-8;
  d.horizon = 20;
  SceneDescription fastest = d;
  fastest.members.reset();
  fastest.body->angular_velocity = {0, 0, 1.5};
  SceneDescription other = fastest;
  other.body->angular_velocity = {0.05, 1.2, 0.05};

  const auto [scene, choice] = resolve_choosing(d).value();
  EXPECT_TRUE(choice->reason.ends_with("of 2 members, in member 1")) << choice->reason;
  for (const SceneDescription& one : {fastest, other}) {
    SceneDescription plain = one;
    plain.tolerance.reset();
    plain.method = scene.description().method;
    SceneDescription fine = plain;
    fine.method = MethodDescription{"exact", {}, {}, ""};
    const auto now = make_simulation(Scene::resolve(plain).value());
    const auto exact = make_simulation(Scene::resolve(fine).value());
    ASSERT_TRUE(now->advance(80).reached() && exact->advance(80).reached());
    EXPECT_LE((now->get("Q") - exact->get("Q")).cwiseAbs().maxCoeff(), 1e-8) << choice->reason;
  }
}

TEST(ChoiceForMembers, OfOneIsThatOfTheSceneAlone) {
  const auto scenes = scenes_of(bodies(1, 4), 0.25);
  SceneDescription alone = scenes.front();
  alone.tolerance = 1e-7;
  alone.horizon = 10;
  const auto [one, of_one] = resolve_choosing(alone).value();
  const auto [together, of_all] = resolve_choosing(asked(scenes, 1e-7, 10)).value();
  EXPECT_EQ(together.method(), one.method());
  EXPECT_EQ(together.order(), one.order());
  EXPECT_EQ(together.substeps(), one.substeps());
  EXPECT_EQ(together.arithmetic(), one.arithmetic());
  EXPECT_TRUE(of_all->reason.starts_with(of_one->reason));
}

TEST(ChoiceForMembers, OfEverySystemThatTakesAMethod) {
  for (const auto& system : catalogue().systems) {
    if (system.discrete) continue;
    std::vector<SceneDescription> scenes;
    for (const unsigned seed : {2u, 3u})
      scenes.push_back(testing::any_scene(std::string(system.name), "", seed, 0.1));
    for (auto& scene : scenes) {
      // What all members share, so that the second has a start of its own and all else in common.
      scene.epsilon = scenes.front().epsilon;
      scene.parameter = scenes.front().parameter;
    }
    if (system.name.starts_with("parametric")) scenes[1] = scenes[0];
    const auto scene = resolve_choosing(asked(scenes, 1e-6, 1));
    ASSERT_TRUE(scene) << system.name << ": " << scene.error().front().rule;
    EXPECT_TRUE(make_simulation(scene->scene)->advance(10).reached()) << system.name;
  }
}

TEST(ChoiceForMembers, ThatCannotBeMadeNamesTheMembers) {
  const auto refused = resolve_choosing(asked(scenes_of(bodies(3, 3), 0.25), 1e-15, 400));
  ASSERT_FALSE(refused);
  const Violation& violation = refused.error().front();
  EXPECT_EQ(violation.field, "tolerance");
  EXPECT_EQ(violation.reason, "TOLERANCE_NOT_MET");
  EXPECT_NE(violation.value.find("(member"), std::string::npos) << violation.value;
}

TEST(ChoiceForMembers, OfTooManyMembersOrTooMuchWorkIsRefused) {
  const auto refused = [](int members, double horizon) {
    SceneDescription d = asked(scenes_of(bodies(1, 4), 0.25), 1e-9, horizon);
    d.members = members;
    for (auto& [name, block] : d.initial)
      block.values = RowMatrix(block.values.replicate(members, 1));
    return resolve_choosing(d).error().front();
  };
  const Violation many = refused(TradeoffRequest::most_members + 1, 10);
  EXPECT_EQ(many.field, "members");
  EXPECT_NE(many.rule.find("give a method"), std::string::npos) << many.rule;
  const Violation dear = refused(1000, 2'500);
  EXPECT_EQ(dear.reason, "TOLERANCE_NOT_MET");
  EXPECT_NE(dear.rule.find("cannot be "), std::string::npos) << dear.rule;
}

/// One refusal tells of a list that is too short for each of 20 members.
TEST(ChoiceForMembers, AFaultOfAllMembersIsToldOnce) {
  SceneDescription d;
  d.system = "rigid_body";
  d.method = MethodDescription{"variational", {}, {}, "", {}};
  d.step = 0.1;
  d.members = 20;
  d.body.emplace().moments = {1, 2, 3};
  d.body->angular_velocity.assign(30, 0.1);
  const auto refused = Scene::resolve(d);
  ASSERT_FALSE(refused);
  ASSERT_EQ(refused.error().size(), 1u);
  EXPECT_EQ(refused.error().front().field, "body.angular_velocity");
  EXPECT_NE(refused.error().front().value.find("(member 0 and others)"), std::string::npos);
}

TEST(TradeoffOfMembers, HasTheErrorOfTheWorstAndTheWorkOfAll) {
  const auto all = bodies(4, 4);
  const auto scenes = scenes_of(all, 0.25);
  const auto table = measured_tradeoff(ensemble_of(scenes), 5, 2e9);
  EXPECT_EQ(table.setup.steps, 20);
  EXPECT_EQ(table.setup.reference_steps, 20);
  ASSERT_GT(table.points.size(), 40u);
  std::vector<testing::Motion> exact;
  for (const RandomBody& body : all)
    exact.push_back(testing::exact_motion(body.lambda, body.Q, body.M, 5));
  for (const auto& point : table.points) {
    if (!point.error || point.extrapolated) continue;
    double attitude = 0, momentum = 0;
    for (std::size_t b = 0; b < all.size(); ++b) {
      SceneDescription one = scenes[b];
      one.method = point.method;
      const auto now = make_simulation(Scene::resolve(one).value());
      ASSERT_TRUE(now->advance(20).reached());
      attitude = std::max(attitude, (now->get("Q") - exact[b].Q).cwiseAbs().maxCoeff());
      momentum = std::max(momentum, (now->get("M") - exact[b].M).cwiseAbs().maxCoeff() /
                                        exact[b].M.cwiseAbs().maxCoeff());
    }
    EXPECT_NEAR(*point.error->attitude, attitude, 1e-3 * attitude + 5e-16);
    EXPECT_NEAR(point.error->momentum, momentum, 1e-3 * momentum + 5e-16);
  }
  // A method with fixed steps takes as many times the work of one.
  const auto alone = measured_tradeoff(scenes.front(), 5, 2e9);
  int compared = 0;
  for (const auto& point : table.points)
    for (const auto& one : alone.points)
      if (one.method.name == point.method.name && one.method.order == point.method.order &&
          one.method.substeps == point.method.substeps &&
          one.method.arithmetic == point.method.arithmetic &&
          one.method.scalar == point.method.scalar && !point.method.tolerance) {
        EXPECT_NEAR(point.work, 4 * one.work, 1e-9 * point.work);
        ++compared;
      }
  EXPECT_GT(compared, 20);
}

TEST(TradeoffOfMembers, KeepsItsBudgetAndItsLimit) {
  SceneDescription d = ensemble_of(scenes_of(bodies(1, 3), 0.25));
  const auto of = [&](int count, double budget) {
    SceneDescription many = d;
    many.members = count;
    for (auto& [name, block] : many.initial)
      block.values = RowMatrix(block.values.replicate(count, 1));
    return Tradeoff::prepare({std::move(many), 10, budget, 1});
  };
  EXPECT_TRUE(of(TradeoffRequest::most_members, 1e9));
  const auto refused = of(TradeoffRequest::most_members + 1, 1e9);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().front().field, "scene.members");
  auto poor = of(1000, 1e6);
  const auto unsolved = (*poor)->solve_reference({});
  ASSERT_FALSE(unsolved);
  EXPECT_EQ(unsolved.error().front().field, "budget");
}

/// A run in which one member leaves the domain says which.
TEST(MeasuredMotions, NameTheMemberThatStops) {
  auto all = bodies(3, 3);
  all[1].M *= 400;
  SceneDescription d = ensemble_of(scenes_of(all, 0.25));
  MeasuredMotions motions(motions_of(d).value());
  motions.solve_references(8, Density::coarse, {2, 1e9, false}, {});
  ASSERT_EQ(motions.samples().last(), 8);
  const MethodDescription method{"variational", 2, 1, "plain"};
  ASSERT_TRUE(motions.take(method));
  const auto made = motions.run(method, 3, {8, Watch::errors});
  EXPECT_EQ(made.status.outcome, Outcome::left_domain);
  EXPECT_EQ(made.status.member, 1);
  EXPECT_EQ(made.steps, 0);
}

}  // namespace
}  // namespace stiefel
