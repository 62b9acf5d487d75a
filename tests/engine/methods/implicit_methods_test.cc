#include <gtest/gtest.h>

#include "engine/body/rigid_body_maps.h"
#include "engine/methods/implicit_midpoint.h"
#include "tests/support/scenes/body_state.h"

namespace stiefel {
namespace {

/// A step that no solver reaches, of a body whose λ spread over 1 : 1e10, leaves every bit, solver
/// history included. (That what a LEFT_DOMAIN names is the edge is seen in tests/extremes.)
template <class Method, class Space>
void expect_untouched(int N, int order, double small, double h) {
  const testing::RandomBody body(N, 3, 1e10);
  const RigidBody<Space> system(body.lambda);
  auto map = map_of(Method(), system, small, order), large = map_of(Method(), system, h, order);
  auto state = map.start(testing::state_of<Space>(body));
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(map.step(state).reached());
  const auto before = testing::numbers_of(state);
  const RunStatus status = large.step(state);
  ASSERT_TRUE(status.outcome == Outcome::left_domain || status.outcome == Outcome::solver_stalled);
  EXPECT_EQ(testing::numbers_of(state), before);
  EXPECT_EQ(status.outcome == Outcome::left_domain, status.largest_step.has_value());
  if (status.largest_step) {
    EXPECT_LT(*status.largest_step, h);
  }
}

TEST(ImplicitMethods, LeaveTheStateWhenTheyFail) {
  expect_untouched<ImplicitMidpoint, SoN<double>>(5, 2, 1e-11, 3);
}

}  // namespace
}  // namespace stiefel
