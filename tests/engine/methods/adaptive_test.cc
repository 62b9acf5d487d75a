#include "engine/methods/adaptive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/systems/rigid_body.h"
#include "tests/support/exact_motion.h"
#include "tests/support/scenes/body_state.h"

namespace stiefel {
namespace {

using testing::RandomBody;

template <class Space>
double error(int N, double h, double tolerance, double time) {
  const RandomBody body(N, 4);
  Adaptive::Map<RigidBody<Space>, Arithmetic::compensated> map(RigidBody<Space>(body.lambda), h, 8,
                                                               tolerance);
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

TEST(Adaptive, GoesBackInTime) {
  const RandomBody body(5, 4);
  const RigidBody<SoN<double>> system(body.lambda);
  Adaptive::Map<RigidBody<SoN<double>>, Arithmetic::compensated> there(system, 3, 8, 1e-11),
      back(system, -3, 8, 1e-11);
  auto state = there.start(testing::state_of<SoN<double>>(body));
  back.start(state.x.value);
  ASSERT_TRUE(there.step(state).reached());
  EXPECT_GT((state.x.value.topRows(5) - body.Q).norm(), 0.1);
  ASSERT_TRUE(back.step(state).reached());
  EXPECT_LT((state.x.value - testing::state_of<SoN<double>>(body)).norm(), 1e-9);
}

/// Units do not matter: with a momentum 2²⁰ times smaller and a time 2²⁰ times longer the motion
/// has the same bits.
TEST(Adaptive, MeasuresMomentumByItself) {
  const RandomBody body(4, 2);
  const double slow = 0x1p-20;
  const auto run = [&](double scale) {
    RandomBody scaled = body;
    scaled.M *= scale;
    Adaptive::Map<RigidBody<SoN<double>>, Arithmetic::plain> map(
        RigidBody<SoN<double>>(scaled.lambda), 3 / scale, 8, 1e-10);
    auto state = map.start(testing::state_of<SoN<double>>(scaled));
    EXPECT_TRUE(map.step(state).reached());
    state.x.value.bottomRows(4) /= scale;
    return state.x.value;
  };
  EXPECT_EQ(run(1), run(slow));
}

/// The solution of ẋ = x² ends at t = 1/x: a step beyond ends with not_finite. A tolerance that
/// cannot be met, or a step that needs too many substeps, ends with solver_stalled.
struct Riccati {
  using Scalar = double;
  using State = Eigen::Matrix<double, 1, 1>;
  static constexpr const char* name = "riccati";
  void field(const State& x, State& dx) const { dx = x.cwiseAbs2(); }
};
TEST(Adaptive, EndsInATypedOutcome) {
  const Riccati::State one(1.0);
  Adaptive::Map<Riccati, Arithmetic::plain> through(Riccati{}, 2, 8, 1e-9),
      up_to(Riccati{}, .5, 8, 1e-12);
  auto state = through.start(one);
  EXPECT_EQ(through.step(state).outcome, Outcome::not_finite);
  EXPECT_EQ(state.x.value, one);
  state = up_to.start(one);
  ASSERT_TRUE(up_to.step(state).reached());
  EXPECT_NEAR(state.x.value(0), 2, 1e-11);

  const RandomBody body(3, 1);
  using Space = SoN<double>;
  Adaptive::Map<RigidBody<Space>, Arithmetic::plain> greedy(RigidBody<Space>(body.lambda), 10, 8,
                                                            1e-18);
  auto x = greedy.start(testing::state_of<Space>(body));
  EXPECT_EQ(greedy.step(x).outcome, Outcome::solver_stalled);
  EXPECT_EQ(x.x.value, testing::state_of<Space>(body));
  Adaptive::Map<RigidBody<Space>, Arithmetic::plain> endless(RigidBody<Space>(body.lambda), 1e7, 8,
                                                             1e-9);
  EXPECT_EQ(endless.step(x).outcome, Outcome::solver_stalled);
}

}  // namespace
}  // namespace stiefel
