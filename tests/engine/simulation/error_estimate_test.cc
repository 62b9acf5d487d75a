#include "stiefel/error_estimate.h"
#include "engine/accuracy/reference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/dense/so_3.h"
#include "stiefel/price.h"
#include "stiefel/simulation.h"
#include "tests/support/motion_in_quadruple.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/random_top.h"
#include "tests/support/surveys/error_survey.h"

namespace stiefel {
namespace {

constexpr double plenty = 5e10;

ErrorEstimate after(const Scene& scene, std::int64_t steps, double budget = plenty) {
  const auto now = make_simulation(scene);
  now->advance(steps);
  return estimate_error(scene, *now, budget, {});
}

/// Every continuous system, method, order and arithmetic, against Bulirsch–Stoer.
TEST(EstimatedError, OfRandomScenesIsTheTrueOne) { testing::expect_estimates(1, 10); }

/// Closed forms against Taylor series: they differ by less than their stated errors, next to the
/// separatrix too.
TEST(ExactReference, SaysHowFarItIsOff) {
  int made = 0, refused = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const testing::RandomTop top(seed);
    SceneDescription d;
    d.system = "rigid_body";
    d.method = MethodDescription{"rk4", {}, {}, ""};
    d.inertia = {top.lambda.begin(), top.lambda.end()};
    const Eigen::Vector3d m = top.x.tail<3>();
    d.initial["Q"] = RowMatrix(RowMatrix::Identity(3, 3));
    d.initial["M"] = RowMatrix(hat(m));
    const double t = top.t * std::min(1.0, 20 / top.one_and_angle());
    d.step = t;
    const Scene scene = Scene::resolve(d).value();
    const MotionState motion = testing::motion_in_quadruple(scene)(t);
    for (const bool quadruple : {false, true}) {
      const ReferenceNeed need{std::abs(t), 1e12, quadruple};
      const auto exact = make_exact_reference(scene, need);
      refused += exact == nullptr;
      if (!exact) continue;
      ++made;
      const auto a = exact->at(t, {});
      ASSERT_TRUE(a) << top.kind << " " << seed;
      EXPECT_LE(error_of(a->state, motion).largest(), a->error)
          << top.kind << " " << seed << " " << exact->description();
      EXPECT_GT(a->error, 0);
    }
  }
  EXPECT_GT(made, 110);
  EXPECT_LT(refused, 10);
}

TEST(ExactReference, IsThereForLambdaOfTwoValuesAndForRoundFrames) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    for (const char* system : {"rigid_body", "stiefel"}) {
      SceneDescription d = testing::any_scene(system, "exact", seed, 7, 5);
      const Scene scene = Scene::resolve(d).value();
      const auto exact = make_exact_reference(scene, {7, 1e12, false});
      ASSERT_TRUE(exact) << system;
      const auto a = exact->at(7, {}), b = make_taylor_reference(scene, {7, 1e12})->at(7, {});
      EXPECT_LE(error_of(a->state, b->state).largest(), a->error + b->error) << system << seed;
      EXPECT_LT(a->error, 1e-14);  // a frame of doubles is orthonormal to rounding only
    }
  }
  EXPECT_FALSE(make_exact_reference(testing::random_scene(5, 1, 0.1, "rk4"), {1, 1e12}));
}

/// In every form of the motion the reference starts from 113 bits, not from rounded conversions.
TEST(ExactReference, OfOtherFormsStartsFromTheirOwnNumbers) {
  for (const char* system : {"right_rigid_body", "symmetric_rigid_body", "reduced_rigid_body",
                             "right_symmetric_rigid_body", "mclachlan_scovel"}) {
    SceneDescription d = testing::any_scene(system, "rk4", 3, 1e-3, 3);
    const Scene scene = Scene::resolve(d).value();
    const ErrorEstimate estimate = after(scene, 100);
    EXPECT_LT(estimate.attitude.value(), 1e-12) << system;
    EXPECT_LT(estimate.momentum.value(), 1e-12) << system;
    EXPECT_NE(estimate.reference.find("closed form"), std::string::npos) << system;
  }
}

TEST(EstimatedError, OfABodyIsAgainstItsTensorAndAngularVelocity) {
  SceneDescription d;
  d.system = "rigid_body";
  d.method = MethodDescription{"exact", {}, {}, ""};
  d.body = BodyDescription{{2, 3, 2.5, 0.3, -0.2, 0.1}, {}, {0.5, 0.5, -0.5, 0.5}, {0.3, 1, -0.7}};
  d.step = 0.5;
  const ErrorEstimate exact = after(Scene::resolve(d).value(), 20);
  EXPECT_LT(exact.attitude.value(), 1e-14);
  EXPECT_LT(exact.momentum.value(), 1e-14);
  const auto by_rk4 = [&](int substeps) {
    d.method = MethodDescription{"rk4", {}, substeps, ""};
    return after(Scene::resolve(d).value(), 20).attitude.value();
  };
  EXPECT_NEAR(by_rk4(16) / by_rk4(32), 16, 3);
}

/// Extended precision tells every error of doubles apart over a hundred steps.
TEST(EstimatedError, TakesExtendedPrecisionWhereThatIsEnough) {
  const ErrorEstimate rough = after(testing::random_scene(5, 1, 0.1, "rk4"), 100);
  EXPECT_NE(rough.reference.find("extended"), std::string::npos) << rough.reference;
  auto d = testing::description(testing::RandomBody(5, 1), 0.01, "variational");
  d.method->order = 8;
  const ErrorEstimate fine = after(Scene::resolve(d).value(), 100);
  EXPECT_LT(fine.attitude.value(), 1e-14);
  EXPECT_LT(fine.reference_error, 1e-16);
}

/// ‖Q̇‖ varies along a geodesic, so a step that is safe at the start leaves the domain later.
TEST(EstimatedError, OfARunThatStoppedIsThatOfItsLastGoodState) {
  const testing::RandomFrame<double> frame(2, 5, 3, 30);
  SceneDescription d;
  d.system = "stiefel";
  d.method = MethodDescription{"variational", 2, {}, ""};
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  d.initial = {{"Q", Block(frame.Q)}, {"S", Block(frame.S)}};
  std::unique_ptr<Simulation> now;
  for (double step = 0.5; step < 20 && !(now && now->step() > 0 && now->step() < 50);
       step *= 1.02) {
    d.step = step;
    now = make_simulation(Scene::resolve(d).value());
    now->advance(50);
  }
  ASSERT_GT(now->step(), 0);
  ASSERT_LT(now->step(), 50);
  const Scene scene = Scene::resolve(d).value();
  const ErrorEstimate stopped = estimate_error(scene, *now, plenty, {});
  EXPECT_EQ(stopped.missing, "");
  EXPECT_EQ(stopped.attitude, after(scene, now->step()).attitude);
}

TEST(EstimatedError, OfAnEnsembleIsThatOfItsWorstMember) {
  const testing::RandomBody slow(3, 1), fast(3, 2);
  SceneDescription d = testing::description(slow, 0.1, "variational");
  d.members = 3;
  RowMatrix Q(9, 3), M(9, 3);
  Q << slow.Q, fast.Q, slow.Q;
  M << slow.M, 3 * fast.M, 2 * slow.M;
  d.initial = {{"Q", Q}, {"M", M}};
  const Scene scene = Scene::resolve(d).value();
  const ErrorEstimate worst = after(scene, 100);
  ASSERT_EQ(worst.member, 1);
  const ErrorEstimate alone = after(scene.members()[1], 100);
  EXPECT_EQ(worst.attitude, alone.attitude);
  EXPECT_NEAR(worst.run_work, 3 * alone.run_work, 1);
  EXPECT_NE(after(scene, 100, 1e4).missing, "");
}

/// An error that is there is at least twice that of the reference; a smaller one is absent.
TEST(EstimatedError, IsAbsentWhereTheReferenceIsNoBetter) {
  int present = 0, absent = 0;
  for (const char* system : {"rigid_body", "symmetric_rigid_body", "stiefel", "double_bracket"})
    for (const char* method : {"exact", "adaptive", "gauss4"})
      for (unsigned seed = 1; seed <= 4; ++seed)
        for (const std::int64_t steps : {0, 1, 50}) {
          SceneDescription d = testing::any_scene(system, method, seed, 1e-3, 3);
          const auto scene = Scene::resolve(d);
          if (!scene) continue;  // not every system has a closed form
          const ErrorEstimate error = after(*scene, steps);
          for (const auto& part : {error.attitude, error.momentum}) {
            ++(part ? present : absent);
            EXPECT_GE(part.value_or(1), 2 * error.reference_error) << system << " " << method;
          }
          EXPECT_EQ(error.missing.empty(), error.attitude || error.momentum) << error.missing;
        }
  EXPECT_GT(present, 20);
  EXPECT_GT(absent, 20);
}

TEST(EstimatedError, SaysWhyThereIsNone) {
  const ErrorEstimate dear = after(testing::random_scene(6, 1, 0.1, "rk4"), 10, 1e5);
  EXPECT_FALSE(dear.attitude || dear.momentum);
  EXPECT_NE(dear.missing.find("would take"), std::string::npos) << dear.missing;
  EXPECT_LE(dear.work, 1e5);

  const Scene discrete = testing::random_scene(4, 1, 0.1, "");
  EXPECT_NE(after(discrete, 10).missing.find("discrete system"), std::string::npos);

  std::stop_source stop;
  stop.request_stop();
  const Scene scene = testing::random_scene(4, 1, 0.1, "rk4");
  const auto now = make_simulation(scene);
  now->advance(10);
  const ErrorEstimate cancelled = estimate_error(scene, *now, plenty, stop.get_token());
  EXPECT_NE(cancelled.missing.find("cancelled"), std::string::npos) << cancelled.missing;

  // One series at N = 200 costs more than the whole budget, so it is not started.
  SceneDescription large = testing::description(testing::RandomBody(200, 1), 0.1, "rk4");
  const ErrorEstimate never = after(Scene::resolve(large).value(), 1);
  EXPECT_NE(never.missing.find("would take"), std::string::npos) << never.missing;
  EXPECT_EQ(never.work, 0);
}

TEST(EstimatedError, KnowsWhatTheRunTakes) {
  SceneDescription d = testing::description(testing::RandomBody(4, 1), 0.1, "variational");
  d.method->substeps = 3;
  const Scene scene = Scene::resolve(d).value();
  const auto now = make_simulation(scene);
  now->advance(10);
  EXPECT_EQ(run_work(scene, *now), step_weight(scene) * static_cast<double>(now->map_steps()));
  EXPECT_EQ(run_work(scene, *make_simulation(scene)), 0);
}

}  // namespace
}  // namespace stiefel
