#include <gtest/gtest.h>

#include "engine/frames/body/stiefel.h"
#include "engine/frames/ellipsoid_maps.h"
#include "engine/frames/stiefel_maps.h"
#include "engine/methods/variational.h"
#include "tests/support/linalg/quadruple.h"
#include "tests/support/scenes/random_frame.h"

namespace stiefel {
namespace {

using testing::Quad;

/// Quadruple precision: the error of order 8 falls from 1e-11 to 1e-15 here.
void expect_orders(int n, int N) {
  const testing::RandomFrame<Quad> frame(n, N, 1);
  const Stiefel<Quad> system(frame.lambda, n);
  const auto at_one = [&](int order, int steps) {
    Variational::Map<Stiefel<Quad>> map(system, Quad(1) / steps, order);
    auto state = map.start(frame.state());
    for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
    return state.x.value;
  };
  const auto exact = at_one(8, 96);
  for (const int order : {2, 4, 6, 8}) {
    const Quad coarse = (at_one(order, 12) - exact).norm(),
               fine = (at_one(order, 24) - exact).norm();
    EXPECT_NEAR(static_cast<double>(log2(coarse / fine)), order, 0.1)
        << "V(" << n << ", " << N << ")";
  }
}

TEST(VariationalOnFrames, HasItsOrderInQuadruplePrecision) {
  expect_orders(1, 4);
  expect_orders(2, 5);
  expect_orders(3, 6);
}

}  // namespace
}  // namespace stiefel
