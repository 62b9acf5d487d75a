// A scene with a tolerance instead of a method.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/accuracy/reference.h"
#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"
#include "stiefel/tradeoff.h"
#include "tests/support/exact_motion.h"
#include "tests/support/extrapolation.h"
#include "tests/support/motion_in_quadruple.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/on_an_ellipse.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/rigid_forms.h"
#include "tests/support/surveys/choice_survey.h"

namespace stiefel {
namespace {

using testing::on_an_ellipse;
using testing::OnAnEllipse;
using testing::Quad;
using testing::RandomBody;

SceneDescription asked(double tolerance, double horizon, int N = 4, double step = 0.25) {
  SceneDescription d = testing::description(RandomBody(N, 6), step, "rk4");
  d.method.reset();
  d.tolerance = tolerance;
  d.horizon = horizon;
  return d;
}

/// With seed 163 runs of `adaptive` at several tolerances end early before one is good.
TEST(Choice, StaysWithinTheToleranceAtAboutTheLeastCost) {
  for (const unsigned seed : {1u, 2u, 163u}) {
    const auto outcome = testing::survey_choice(seed);
    EXPECT_TRUE(outcome.made) << outcome.scene << ": " << outcome.chosen;
    EXPECT_LE(outcome.error, 1) << outcome.scene << ": " << outcome.chosen;
    EXPECT_LE(outcome.cost, 2) << outcome.scene << ": " << outcome.chosen;
    EXPECT_GT(outcome.cost, 0) << outcome.scene;
  }
}

/// The error of a chosen scene at its horizon over its tolerance, `exact` being blocks that its
/// simulation reports; 0 where the tolerance is refused as one that cannot be met.
double error_over_tolerance(const SceneDescription& d, const auto& exact) {
  const auto chosen = resolve_choosing(d);
  if (!chosen) {
    EXPECT_EQ(chosen.error().front().reason, "TOLERANCE_NOT_MET") << chosen.error().front().rule;
    return 0;
  }
  const auto& [scene, choice] = *chosen;
  const auto now = make_simulation(scene);
  EXPECT_TRUE(now->advance(std::llround(*d.horizon / scene.step())).reached());
  const MotionState state = read_motion(scene, *now);
  const double error = error_of(state, exact(scene)).largest();
  EXPECT_LE(error, *d.tolerance) << choice->reason;
  return error / *d.tolerance;
}

/// A scene on which one substep of `adaptive` reaches rounding at every tolerance.
TEST(Choice, OfADoubleBracketStaysWithinItsTolerance) {
  int made = 0;
  for (const auto& [seed, tolerance, horizon] :
       {std::tuple{1u, 1e-12, 400.0}, {2u, 1e-12, 100.0}, {3u, 1e-12, 100.0}, {4u, 1e-9, 50.0}}) {
    testing::RandomMatrices<double> random(seed);
    SceneDescription d;
    d.system = "double_bracket";
    d.inertia_u = {1, 1.7, 2.5};
    d.inertia_v = {0.8, 1.9};
    for (const char* name : {"Q", "P"})
      d.initial[name] =
          Block(RowMatrix(random.matrix(3, 2) / 2), RowMatrix(random.matrix(3, 2) / 2));
    d.step = 0.05;
    d.tolerance = tolerance;
    d.horizon = horizon;
    made += error_over_tolerance(d, [&](const Scene& scene) {
              const auto lambda = [](const std::vector<double>& l) -> Vector<Quad> {
                return Eigen::Map<const Eigen::VectorXd>(l.data(), std::ssize(l)).cast<Quad>();
              };
              Matrix<Quad> x(12, 2);
              x << scene.block("Q").cast<Quad>(), scene.block("P").cast<Quad>();
              x = testing::extrapolate(
                  testing::PrintedDoubleBracket(lambda(d.inertia_u), lambda(d.inertia_v)), x,
                  Quad(horizon), static_cast<int>(4 * horizon));
              MotionState exact{Matrix<long double>(3, 4), Matrix<long double>(3, 4), true};
              for (int j = 0; j < 2; ++j)
                for (int part = 0; part < 2; ++part) {
                  exact.attitude.col(2 * j + part) =
                      x.col(j).segment(3 * part, 3).cast<long double>();
                  exact.momentum.col(2 * j + part) =
                      x.col(j).segment(6 + 3 * part, 3).cast<long double>();
                }
              return exact;
            }) > 0;
  }
  EXPECT_GE(made, 2);
}

TEST(Choice, OfAParametricRigidBodyStaysWithinItsTolerance) {
  int made = 0;
  for (const auto& [seed, tolerance] : {std::pair{1u, 1e-11}, {3u, 1e-8}}) {
    SceneDescription d = testing::any_scene("parametric_rigid_body", "", seed, 0.05);
    d.tolerance = tolerance;
    d.horizon = 100;
    made +=
        error_over_tolerance(d, [&](const Scene& scene) {
          const testing::PrintedParametricRigidBody printed(scene.inertia().cast<Quad>(),
                                                            scene.parameter());
          Matrix<Quad> x(8, 4);
          x << scene.Q().cast<Quad>(), scene.block("P").cast<Quad>();
          x = testing::extrapolate(printed, x, Quad(*d.horizon), 400);
          return MotionState{x.topRows(4).cast<long double>(), printed.M(x).cast<long double>()};
        }) > 0;
  }
  EXPECT_GE(made, 1);
}

/// The largest error over the tolerance of a chosen scene at 97 times up to its horizon, against
/// the motion in quadruple precision, in closed form where there is one; 0 where the tolerance is
/// refused as one that cannot be met.
double largest_error_over_tolerance(const SceneDescription& d) {
  const auto chosen = resolve_choosing(d);
  if (!chosen) {
    EXPECT_EQ(chosen.error().front().reason, "TOLERANCE_NOT_MET") << chosen.error().front().rule;
    return 0;
  }
  const auto& [scene, choice] = *chosen;
  EXPECT_LE(choice->error, choice->tolerance) << choice->reason;
  const std::int64_t steps = std::llround(*d.horizon / scene.step());
  const auto closed_form = make_exact_reference(scene, {*d.horizon, 1e13});
  const auto series = testing::motion_in_quadruple(scene);
  const auto exact = [&](double t) {
    return closed_form ? closed_form->at(t, {})->state : series(t);
  };
  const auto now = make_simulation(scene);
  double error = 0;
  for (std::int64_t k = 1; k <= 97; ++k) {
    const std::int64_t step = steps * k / 97;
    EXPECT_TRUE(now->advance(step - now->step()).reached());
    const MotionError of_step = error_of(read_motion(scene, *now), exact(scene.time(step)));
    error = std::max(error, of_step.largest());
  }
  EXPECT_LE(error, 1.05 * choice->tolerance) << choice->reason;
  return error / choice->tolerance;
}

/// A chaotic geodesic: no method in double precision keeps the small tolerances.
TEST(Choice, OfAChaoticGeodesicStaysWithinTheTolerance) {
  int made = 0;
  for (const double tolerance : {1e-5, 1e-9}) {
    const testing::RandomFrame<double> frame(2, 5, 3);
    SceneDescription d;
    d.system = "stiefel";
    d.inertia = {1, 2, 3, 5, 8};
    const Eigen::Map<const Eigen::VectorXd> lambda(d.inertia.data(), 5);
    const Eigen::MatrixXd Qdot = frame.S * frame.lambda.cwiseInverse().asDiagonal();
    d.initial = {{"Q", frame.Q}, {"S", RowMatrix(Qdot * lambda.asDiagonal())}};
    d.step = 0.1;
    d.tolerance = tolerance;
    d.horizon = 60;
    SCOPED_TRACE(tolerance);
    made += largest_error_over_tolerance(d) > 0;
  }
  EXPECT_GE(made, 1);
}

TEST(Choice, IsKeptAtEveryStep) {
  std::vector<SceneDescription> scenes = {on_an_ellipse(101.8, 0.857, -1.18, 0.138, 2.9e-4, 3819),
                                          on_an_ellipse(1210, 5.74, 0.9, 0.059, 3.3e-5, 3727)};
  SceneDescription& flat = scenes.emplace_back(scenes.front());
  flat.inertia = {1, 3467.038735465146};
  flat.initial["Q"] = RowMatrix(Eigen::RowVector2d(0.6765693056502934, 0.7363789613044903));
  flat.initial["S"] = RowMatrix(Eigen::RowVector2d(-0.018481429158329375, 58.87150858044873));
  flat.step = 0.12805466387052025;
  flat.tolerance = 3.505945670270743e-06;
  flat.horizon = 640.2733193526012;
  for (const SceneDescription& d : scenes) {
    SCOPED_TRACE(d.inertia.back());
    const auto chosen = resolve_choosing(d);
    ASSERT_TRUE(chosen) << chosen.error().front().rule;
    const auto& [scene, choice] = *chosen;
    const OnAnEllipse exact(scene);
    const auto now = make_simulation(scene);
    double largest = 0;
    for (std::int64_t k = 1; k <= std::llround(*d.horizon / *d.step); ++k) {
      ASSERT_TRUE(now->advance(1).reached());
      const double error = error_of(read_motion(scene, *now), exact.at(scene.time(k))).largest();
      ASSERT_LE(error, *d.tolerance) << "step " << k << ": " << choice->reason;
      largest = std::max(largest, error);
    }
    EXPECT_LE(largest, choice->error) << choice->reason;
  }
}

/// 10⁸ states of the reference are too many to compare: the closed form needs no comparison between
/// samples.
TEST(Choice, OfManyStepsIsTheClosedForm) {
  const auto [scene, choice] = resolve_choosing(asked(1e-6, 5e6, 3, 0.05)).value();
  EXPECT_EQ(choice->method.name, "exact");
  EXPECT_LE(choice->error, 1e-6);
  EXPECT_NE(choice->reason.find("of 100000000 steps"), std::string::npos) << choice->reason;
  const auto refused = resolve_choosing(asked(1e-14, 5e6, 3, 0.05));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().front().reason, "TOLERANCE_NOT_MET");
}

/// 300 000 states of the reference are too many; 10⁸ steps of a run are.
TEST(Choice, ThatCannotBeVerifiedIsRefused) {
  for (const SceneDescription& d : {asked(1e-6, 300, 4, 0.001), asked(1e-3, 1e6, 4, 0.01)}) {
    const auto refused = resolve_choosing(d);
    ASSERT_FALSE(refused);
    const Violation& violation = refused.error().front();
    EXPECT_EQ(violation.reason, "TOLERANCE_NOT_MET");
    EXPECT_NE(violation.rule.find("cannot be verified"), std::string::npos) << violation.rule;
    EXPECT_NE(violation.rule.find(" of the 3e+09 and 64 MiB"), std::string::npos) << violation.rule;
  }
}

TEST(Choice, CostsMoreForMoreAccuracy) {
  double first = 0, last = 0;
  for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-12}) {
    const auto [scene, choice] = resolve_choosing(asked(tolerance, 20)).value();
    const std::string& text = choice->reason;
    const auto now = make_simulation(scene);
    ASSERT_TRUE(now->advance(80).reached());
    const RandomBody body(4, 6);
    const auto exact = testing::exact_motion(body.lambda, body.Q, body.M, 20);
    const double error = (now->get("Q") - exact.Q).cwiseAbs().maxCoeff();
    EXPECT_LE(error, tolerance) << text;
    EXPECT_GT(error, 1e-4 * tolerance) << text;  // not far better than asked
    const double work = std::stod(text.substr(text.find(" at ") + 4));
    EXPECT_GE(work, last) << text;
    last = work;
    if (first == 0) first = work;
  }
  EXPECT_GT(last, 4 * first);
}

/// Where the reference leaves little of the work for runs, a dear run must not take it from a cheap
/// one.
TEST(Choice, IsAsCheapWhereLittleWorkIsLeft) {
  for (const std::int64_t steps : {40000, 45000, 50000, 55000}) {
    SceneDescription d = testing::description(RandomBody(4, 2), 0.05, "rk4");
    d.method.reset();
    d.inertia = {1, 1.5, 2, 2.5};
    d.initial.at("M").values /= testing::operator_norm(d.initial.at("M").values);
    d.tolerance = 1e-6;
    d.horizon = 0.05 * static_cast<double>(steps);
    const auto [scene, choice] = resolve_choosing(d).value();
    EXPECT_EQ(scene.method(), "rk4") << choice->reason;
    EXPECT_EQ(scene.substeps(), 1) << choice->reason;
  }
}

}  // namespace
}  // namespace stiefel
