
#include <gtest/gtest.h>

#include "engine/body/rigid_body_maps.h"
#include "engine/frame/stiefel.h"
#include "engine/frame/stiefel_maps.h"
#include "engine/methods/variational.h"
#include "tests/support/linalg/quadruple.h"
#include "tests/support/scenes/body_state.h"
#include "tests/support/scenes/random_frame.h"

namespace stiefel {
namespace {

using testing::Quad;
using testing::RandomBody;

/// The order conditions on the sums of powers, Σγ = 1, Σγ^k = 0, to quadruple rounding.
TEST(SymmetricStages, SatisfyTheOrderConditions) {
  for (const int order : {4, 6, 8}) {
    const auto gamma = symmetric_stages<Quad>(order);
    for (int k = 1; k < order; k += 2) {
      Quad sum = pow(gamma.back(), k) - (k == 1 ? 1 : 0);
      for (std::size_t i = 0; i + 1 < gamma.size(); ++i) sum += 2 * pow(gamma[i], k);
      EXPECT_LT(static_cast<double>(abs(sum)), 1e-32) << order << " " << k;
    }
    const auto rounded = symmetric_stages<double>(order);
    for (std::size_t i = 0; i < gamma.size(); ++i)
      EXPECT_NEAR(static_cast<double>(gamma[i] - rounded[i]), 0, 1e-15);
  }
  EXPECT_THROW(symmetric_stages<double>(5), std::invalid_argument);
}

/// Quadruple precision: the error of order 8 falls from 1e-11 to 1e-15 here.
void expect_orders(int n, int N) {
  const testing::RandomFrame<Quad> frame(n, N, 1);
  const Stiefel<Quad> system(frame.lambda, n);
  const auto at_one = [&](int order, int steps) {
    auto map = map_of(Variational(), system, Quad(1) / steps, order);
    auto state = map.start(frame.state());
    for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
    return state.x.value;
  };
  const auto exact = at_one(8, 96);
  for (const int order : {2, 4, 6, 8}) {
    const Quad coarse = (at_one(order, 12) - exact).norm(),
               fine = (at_one(order, 24) - exact).norm();
    EXPECT_NEAR(std::log2(static_cast<double>(coarse / fine)), order, 0.1)
        << "V(" << n << ", " << N << ")";
  }
}

TEST(VariationalOnFrames, HasItsOrderInQuadruplePrecision) {
  expect_orders(1, 4);
  expect_orders(2, 5);
  expect_orders(3, 6);
}

template <class Space>
void expect_order_2_to_be_the_base_map(int N) {
  const RandomBody body(N, 2);
  auto composed = map_of(Variational(), RigidBody<Space>(body.lambda), 0.1, 2);
  MoserVeselov<Space> base(body.lambda, 0.1);
  auto a = composed.start(testing::state_of<Space>(body));
  auto b = base.start(testing::state_of<Space>(body));
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(composed.step(a).reached());
    ASSERT_TRUE(base.step(b).reached());
  }
  EXPECT_EQ(testing::numbers_of(a), testing::numbers_of(b));
}
TEST(Composition, OfOrderTwoIsTheBaseMap) {
  expect_order_2_to_be_the_base_map<So3<double, true>>(3);
  expect_order_2_to_be_the_base_map<SoN<double>>(5);
}

/// A step beyond the domain leaves every bit of the state, solver memories included; the largest
/// step it names exists, and one a little longer does not.
template <class Space>
void expect_typed_failure(int N, int order) {
  const RandomBody body(N, 3);
  const RigidBody<Space> system(body.lambda);
  auto small = map_of(Variational(), system, 0.1, order),
       large = map_of(Variational(), system, 20.0, order);
  auto state = small.start(testing::state_of<Space>(body));
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(small.step(state).reached());
  const auto before = testing::numbers_of(state);
  const RunStatus status = large.step(state);
  EXPECT_EQ(status.outcome, Outcome::left_domain);
  EXPECT_EQ(testing::numbers_of(state), before);
  const double largest = status.largest_step.value();
  EXPECT_NEAR(small.largest_step(state, 20).value(), largest, 4e-3 * largest);
  const auto exists = [&](double h) {
    auto copy = large.start(state.x.value);
    return map_of(Variational(), system, h, order).step(copy).reached();
  };
  EXPECT_TRUE(exists(0.999 * largest)) << N << " " << order;
  EXPECT_FALSE(exists(1.003 * largest)) << N << " " << order;
}
TEST(Composition, FailsAsOneStep) {
  for (const int order : {4, 6, 8}) {
    expect_typed_failure<So3<double, true>>(3, order);
    expect_typed_failure<SoN<double>>(4, order);
  }
}

}  // namespace
}  // namespace stiefel
