#include "engine/methods/adaptive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/body/rigid_body.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/stiefel.h"
#include "engine/frame/stiefel_costate.h"
#include "engine/frame/stiefel_momenta.h"
#include "tests/support/exact_motion.h"
#include "tests/support/scenes/body_state.h"
#include "tests/support/scenes/random_frame.h"

namespace stiefel {
namespace {

using testing::RandomBody;

template <class Space>
double error(int N, double h, double tolerance, double time) {
  const RandomBody body(N, 4);
  Adaptive::Map<RigidBody<Space>> map(RigidBody<Space>(body.lambda), h,
                                      {8, Arithmetic::compensated, tolerance});
  auto state = map.start(testing::state_of<Space>(body));
  for (int k = 0; k < std::lround(time / h); ++k) EXPECT_TRUE(map.step(state).reached());
  const auto exact = testing::exact_motion(body.lambda, body.Q, body.M, time);
  return (testing::frame_of(state.x.value) - exact.Q).norm();
}

/// The error is `tolerance` a step, magnified by the motion at most 100 times in ten units of time.
/// Where the method chooses its substeps, the error is not far below the tolerance either.
TEST(Adaptive, MeetsItsTolerance) {
  for (const double h : {0.5, 10.0})
    for (const double tolerance : {1e-6, 1e-9, 1e-12}) {
      const double time = 10;
      const double worst = std::max(error<So3<double, true>>(3, h, tolerance, time),
                                    error<SoN<double>>(7, h, tolerance, time));
      EXPECT_LT(worst, 100 * tolerance) << h;
      if (h == 10) {
        EXPECT_GT(worst, 1e-3 * tolerance);
      }
    }
}

/// Units do not matter: with a momentum 2²⁰ times smaller and a time 2²⁰ times longer the motion
/// has the same bits.
TEST(Adaptive, MeasuresMomentumByItself) {
  const RandomBody body(4, 2);
  const double slow = 0x1p-20;
  const auto run = [&](double scale) {
    RandomBody scaled = body;
    scaled.M *= scale;
    Adaptive::Map<RigidBody<SoN<double>>> map(RigidBody<SoN<double>>(scaled.lambda), 3 / scale,
                                              {8, Arithmetic::plain, 1e-10});
    auto state = map.start(testing::state_of<SoN<double>>(scaled));
    EXPECT_TRUE(map.step(state).reached());
    state.x.value.bottomRows(4) /= scale;
    return state.x.value;
  };
  EXPECT_EQ(run(1), run(slow));
}

/// Below the rounding of the vector field no substep meets a tolerance; the error is then that of
/// rounding.
TEST(Adaptive, ReachesRoundingWhereTheToleranceIsBelowIt) {
  for (const double tolerance : {1e-15, 1e-18})
    EXPECT_LT(error<SoN<double>>(5, 1, tolerance, 10), 1e-13) << tolerance;
}

/// Λ = (0.01, 1, 100): rounding in Ṡ is more than the tolerance. The right state at t = 2 is from
/// Taylor series of order 26 in extended precision (numpy).
TEST(Adaptive, GoesOnWhereRoundingIsMagnifiedByTheInertia) {
  Matrix<double> start(4, 3), end(4, 3);
  start << 1, 0, 0, 0, 1, 0, 0, 1, 25, -0.01, 0, -50;
  end << -0.8735490262626164, -0.2711411063277552, 0.4042209781480863, -0.4769426870666941,
      0.3110729478744779, -0.8220457982097372, 0.0059749191655501, -2.2914475953834640,
      -24.582384282274246, -0.0072803945945628, 0.0932763721624670, 45.769816348271236;
  const Vector<double> lambda = Eigen::Vector3d(0.01, 1, 100);
  Adaptive::Map<Stiefel<double>> map(Stiefel<double>(lambda, 2), 0.0625,
                                     {8, Arithmetic::plain, 5e-14});
  auto state = map.start(start);
  for (int k = 1; k <= 1600; ++k) {
    ASSERT_TRUE(map.step(state).reached()) << k;
    if (k == 32) {
      EXPECT_LT((state.x.value - end).cwiseAbs().maxCoeff() / 50, 1e-10);
    }
  }
}

/// Q Qᵀ = I, and the constraint of S, hold in every state that is reported, whatever the tolerance;
/// m = PQᵀ − QPᵀ and the energy are within the error of the method.
TEST(Adaptive, EndsEveryStepOnTheManifold) {
  static constexpr double rounding = 8 * 0x1p-53, tolerance = 1e-6, h = 0.5;
  const auto run = [&]<class S>(S system, Matrix<double> x, auto&& check) {
    Adaptive::Map<S> map(std::move(system), h, {8, Arithmetic::compensated, tolerance});
    auto state = map.start(x);
    for (int k = 0; k < 200; ++k) {
      ASSERT_TRUE(map.step(state).reached());
      check(state.x.value);
    }
  };
  for (const auto& [n, N] : {std::pair{1, 4}, {2, 5}, {3, 4}}) {
    const testing::RandomFrame<double> frame(n, N, 3);
    const auto inverse = frame.lambda.cwiseInverse().asDiagonal();
    const Matrix<double> m = momentum_m<double>(frame.Q, frame.S);
    const auto on_frames = [n = n](const Matrix<double>& x) {
      EXPECT_LE(orthogonality_defect(x.topRows(n)), rounding);
    };
    run(Stiefel<double>(frame.lambda, n), frame.state(), [&](const Matrix<double>& x) {
      on_frames(x);
      const Matrix<double> Q = x.topRows(n), S = x.bottomRows(n),
                           along = Q * inverse * S.transpose();
      EXPECT_LE((along + along.transpose()).cwiseAbs().maxCoeff(), rounding);
      EXPECT_LE((momentum_m<double>(Q, S) - m).norm(), 1e-2 * S.norm());
    });
    Matrix<double> costate = frame.state();
    costate.bottomRows(n) += 0.3 * frame.Q;
    run(StiefelCostate<double>(frame.lambda, n), costate, on_frames);
  }
}

/// The solution of ẋ = x² ends at t = 1/x: a step beyond ends with not_finite. A step that needs
/// too many substeps ends with solver_stalled.
struct Riccati {
  using Scalar = double;
  using State = Eigen::Matrix<double, 1, 1>;
  static constexpr const char* name = "riccati";
  void field(const State& x, State& dx) const { dx = x.cwiseAbs2(); }
};
TEST(Adaptive, EndsInATypedOutcome) {
  const Riccati::State one(1.0);
  Adaptive::Map<Riccati> through(Riccati{}, 2, {8, Arithmetic::plain, 1e-9}),
      up_to(Riccati{}, .5, {8, Arithmetic::plain, 1e-12});
  auto state = through.start(one);
  EXPECT_EQ(through.step(state).outcome, Outcome::not_finite);
  EXPECT_EQ(state.x.value, one);
  state = up_to.start(one);
  ASSERT_TRUE(up_to.step(state).reached());
  EXPECT_NEAR(state.x.value(0), 2, 1e-11);

  const RandomBody body(3, 1);
  using Space = SoN<double>;
  Adaptive::Map<RigidBody<Space>> endless(RigidBody<Space>(body.lambda), 1e7,
                                          {8, Arithmetic::plain, 1e-9});
  auto x = endless.start(testing::state_of<Space>(body));
  EXPECT_EQ(endless.step(x).outcome, Outcome::solver_stalled);
  EXPECT_EQ(x.x.value, testing::state_of<Space>(body));
}

}  // namespace
}  // namespace stiefel
