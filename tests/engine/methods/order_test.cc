#include <gtest/gtest.h>

#include <cmath>

#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "methods/all_methods.h"
#include "tests/support/exact_motion.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::RandomBody;

template <class Space>
typename Space::State point(const RandomBody& body) {
  if constexpr (std::is_same_v<Space, SoN<double>>) {
    typename Space::State x(2 * body.M.rows(), body.M.cols());
    x << body.Q, body.M;
    return x;
  } else {
    typename Space::State x;
    x << quaternion_of(body.Q), vee(body.M);
    return x;
  }
}

template <class State>
Eigen::MatrixXd frame(const State& x) {
  if constexpr (State::ColsAtCompileTime == 1)
    return rotation_matrix<double>(x.template head<4>());
  else
    return x.topRows(x.cols());
}

/// Error of the frame at t = 1, against a solution in extended precision by another method.
template <class Method, class Space>
double error(const RandomBody& body, const testing::Motion& exact, int steps) {
  typename Method::template Map<RigidBody<Space>> map(
      RigidBody<Space>(body.lambda), 1.0 / steps, Method::traits.default_order);
  auto state = map.start(point<Space>(body));
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
  return (frame(state.x.value) - exact.Q).norm();
}

template <class Method, class Space>
void expect_order(int) {}
template <class Method, class Space>
requires applies<Method, RigidBody<Space>>
void expect_order(int N) {
  if constexpr (Method::traits.default_tolerance > 0) return;  // it has a tolerance, not a step
  if (Method::traits.default_order == 0) return;               // it is exact
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const RandomBody body(N, seed);  // a full random momentum: Ω(t) does not commute with Ω(0)
    const auto exact = testing::exact_motion(body.lambda, body.Q, body.M, 1);
    const double coarse = error<Method, Space>(body, exact, 40);
    const double fine = error<Method, Space>(body, exact, 80);
    EXPECT_NEAR(std::log2(coarse / fine), Method::traits.default_order, 0.1)
        << Method::traits.name << " N=" << N << " seed " << seed << ": " << coarse << " " << fine;
  }
}

template <class... M>
void expect_orders(TypeList<M...>) {
  (expect_order<M, So3<double, true>>(3), ...);
  for (const int N : {3, 4, 7}) (expect_order<M, SoN<double>>(N), ...);
}

TEST(Order, IsTheDeclaredOneForEveryMethodAndSpace) { expect_orders(Methods{}); }

}  // namespace
}  // namespace stiefel
