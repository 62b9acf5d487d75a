#include "engine/methods/preprocessed_variational.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/body/rigid_body_maps.h"
#include "engine/methods/exact.h"
#include "engine/methods/variational.h"
#include "stiefel/simulation.h"
#include "tests/support/linalg/quadruple.h"
#include "tests/support/printed_series.h"
#include "tests/support/scenes/body_state.h"

namespace stiefel {
namespace {

using testing::Quad;
using Body = RigidBody<So3<Quad, true>>;

/// A body in three dimensions and where it starts.
struct Start {
  Vector<Quad> lambda;
  Body::State x;

  static Start of(const Vector3<Quad>& I, const Vector3<Quad>& m) {
    Start start;
    start.lambda = (I.sum() / 2 - I.array()).matrix();
    start.x << 1, 0, 0, 0, m;
    return start;
  }
  static Start random(unsigned seed) {
    const testing::RandomBody body(3, seed);
    return {body.lambda.cast<Quad>(), testing::state_of<So3<Quad, true>>(body)};
  }

  Body::State exact(Quad t = 1) const {
    return EulerTop<Quad>(PrincipalMoments3<Quad>(lambda), x).at(t);
  }
  template <class Map>
  Body::State run(Map map, int steps) const {
    auto state = map.start(x);
    for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
    return state.x.value;
  }
  /// The error of the quaternion at t = 1.
  double error(int order, int steps) const {
    const Quad h = Quad(1) / steps;
    const Body body(lambda);
    const Body::State end = order == 2
                                ? run(map_of(Variational(), body, h, 2), steps)
                                : run(map_of(PreprocessedVariational(), body, h, order), steps);
    return static_cast<double>((end - exact()).head<4>().norm());
  }
};

const auto orders = PreprocessedVariational::traits.orders;

TEST(PreprocessedVariational, HasItsOrders) {
  for (unsigned seed = 1; seed <= 4; ++seed)
    for (const int order : orders) {
      const Start start = Start::random(seed);
      // Coarse enough for quadruple precision to see the errors.
      const int steps = order > 14 ? 4 : order > 10 ? 10 : 80;
      EXPECT_NEAR(std::log2(start.error(order, steps) / start.error(order, 2 * steps)), order, 0.05)
          << seed;
    }
}

/// The series found from the motion is the published one, from whichever point of the motion.
TEST(PreprocessedVariational, HasThePublishedSeries) {
  const Quad h = 0.1;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Start start = Start::random(seed);
    const PrincipalMoments3<Quad> I(start.lambda);
    const Vector3<Quad> m = start.x.tail<3>(), later = start.exact().tail<3>();
    for (const int order : {4, 6, 8, 10}) {
      const auto published = testing::PrintedSeries<Quad>(I, order).inverse(m, h);
      for (const Vector3<Quad>& point : {m, later}) {
        const auto J = ModifiedSeries<Quad>(BodyOfSeries<Quad>(I), point, order)(h);
        EXPECT_LT(
            static_cast<double>((J.moments.cwiseProduct(published).array() - 1).abs().maxCoeff()),
            1e-31);
        for (int i = 0; i < 3; ++i)
          EXPECT_LT(static_cast<double>(
                        abs(J.moments((i + 1) % 3) - J.moments((i + 2) % 3) - J.differences(i))),
                    1e-31);
      }
    }
  }
}

/// In the limit of high order the discrete body makes exact steps.
TEST(PreprocessedVariational, ConvergesToExactSteps) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Start start = Start::random(seed);
    const PrincipalMoments3<Quad> I(start.lambda);
    const Vector3<Quad> m = start.x.tail<3>();
    const Quad h = Quad(0.5) / m.cwiseQuotient(I.moments).norm();
    const BodyOfSeries<Quad> of_series(I);
    const auto twenty = ModifiedSeries<Quad>(of_series, m, 40)(h),
               twice = ModifiedSeries<Quad>(of_series, m, 80)(h);
    EXPECT_LT(static_cast<double>((twenty.moments - twice.moments).norm()), 1e-20);
    DiscreteBody3<Quad, true> body;
    Accumulator<Body::State> x(start.x, Arithmetic::compensated);
    const DiscreteInertia3<Quad> J(twice, h);
    ASSERT_TRUE(body.solve(x, J));
    body.transport(x, J);
    EXPECT_LT(static_cast<double>((x.value - start.exact(h)).norm()), 1e-30) << seed;
  }
}

/// The example of Hairer and Vilmart 2006.
TEST(PreprocessedVariational, HasThePublishedErrors) {
  const auto decimal = [](int digits, int places) { return Quad(digits) / pow(Quad(10), places); };
  const Start start = Start::of({decimal(345, 3), decimal(653, 3), 1},
                                {decimal(18, 1), decimal(4, 1), decimal(-9, 1)});
  EXPECT_NEAR(start.error(2, 40), 7.8e-3, 0.05e-3);
  EXPECT_NEAR(start.error(4, 40), 7.2e-6, 0.05e-6);
  EXPECT_NEAR(start.error(6, 40), 3.2e-9, 0.05e-9);
  EXPECT_NEAR(start.error(8, 40), 8.6e-13, 0.05e-13);
  EXPECT_NEAR(start.error(10, 40), 1.6e-16, 0.05e-16);
}

/// Where the modified moments are not positive, the outcome names the longest step that exists.
TEST(PreprocessedVariational, NamesTheLargestStep) {
  using Space = So3<double, true>;
  const testing::RandomBody body(3, 3);
  const RigidBody<Space> system(body.lambda);
  auto far = map_of(PreprocessedVariational(), system, 10.0, 10);
  auto state = far.start(testing::state_of<Space>(body));
  const auto before = testing::numbers_of(state);
  const RunStatus status = far.step(state);
  ASSERT_EQ(status.outcome, Outcome::left_domain);
  EXPECT_EQ(testing::numbers_of(state), before);
  const double h = status.largest_step.value();
  EXPECT_GT(h, 0.5);
  auto inside = map_of(PreprocessedVariational(), system, h, 10);
  state = inside.start(testing::state_of<Space>(body));
  EXPECT_TRUE(inside.step(state).reached());
}

/// At h|ω| = 1.5 order 6 has no step, and from 1.7 on its equation is solvable again, on no branch
/// that starts at the identity: there is no step of that length either.
TEST(PreprocessedVariational, TakesNoStepBeyondAGap) {
  using Space = So3<double, true>;
  const testing::RandomBody body(3, 1);
  const RigidBody<Space> system(body.lambda);
  const auto start = testing::state_of<Space>(body);
  const PrincipalMoments3<double> I(body.lambda);
  const double omega = start.tail<3>().cwiseQuotient(I.moments).norm();
  for (const double turn : {1.55, 2.0, 3.0, 3.5, -3.0}) {
    auto map = map_of(PreprocessedVariational(), system, turn / omega, 6);
    auto state = map.start(start);
    const RunStatus status = map.step(state);
    ASSERT_EQ(status.outcome, Outcome::left_domain) << turn;
    EXPECT_NEAR(status.largest_step.value() * omega, 1.45, 0.05) << turn;
  }
}

/// J of rods of any thinness: a tumbling one follows the exact motion like any other body.
TEST(PreprocessedVariational, FollowsThinRods) {
  for (const double thin : {1e-3, 1e-6, 1e-9, 1e-12})
    for (const int order : orders) {
      Start start = Start::of({1, 1 + Quad(thin) / 3, thin}, {0.5, -0.7, 0.8 * Quad(thin)});
      const Vector<double> lambda = start.lambda.cast<double>();
      start.lambda = lambda.cast<Quad>();
      using Space = So3<double, true>;
      auto map = map_of(PreprocessedVariational(), RigidBody<Space>(lambda), 0.05, order);
      auto state = map.start(start.x.cast<double>());
      for (int k = 0; k < 20; ++k) ASSERT_TRUE(map.step(state).reached()) << thin << " " << order;
      const Quad error = (state.x.value.cast<Quad>() - start.exact()).head<4>().norm();
      EXPECT_LT(static_cast<double>(error), std::max(std::pow(0.05, order), 2e-15))
          << thin << " " << order;
    }
}

}  // namespace
}  // namespace stiefel
