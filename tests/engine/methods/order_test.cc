#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "engine/body/rigid_body_maps.h"
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
double error(const RandomBody& body, const testing::Motion& exact, int steps, int order) {
  auto map = map_of(Method(), RigidBody<Space>(body.lambda), 1.0 / steps, order);
  auto state = map.start(point<Space>(body));
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
  return (frame(state.x.value) - exact.Q).norm();
}

/// The order is measured between two steps, one half of the other, whose errors are below 1e-3,
/// where the leading term decides, and above 1e-12, where rounding does not.
template <class Method, class Space>
void expect_order(int N, int order) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const RandomBody body(N, seed);  // a full random momentum: Ω(t) does not commute with Ω(0)
    const auto exact = testing::exact_motion(body.lambda, body.Q, body.M, 1);
    const double below = std::pow(0.1, 3 + order / 2.0);
    int steps = 4;
    double coarse = error<Method, Space>(body, exact, steps, order);
    while (coarse > below) coarse = error<Method, Space>(body, exact, steps *= 2, order);
    const double fine = error<Method, Space>(body, exact, 2 * steps, order);
    EXPECT_GT(fine, 1e-13);
    EXPECT_NEAR(std::log2(coarse / fine), order, order < 5 ? 0.1 : 0.05 * order)
        << "seed " << seed << ", " << steps << " steps: " << coarse << " " << fine;
  }
}

struct Measured {
  std::string name;
  std::function<void()> measure;
  friend void PrintTo(const Measured& measured, std::ostream* out) { *out << measured.name; }
};

/// Every order of a method that takes steps of a fixed size and is not exact. Errors of orders
/// above 8 are below rounding here; PreprocessedVariational.HasItsOrders measures them.
template <class Method, class Space>
void add(int N, const std::string& space, std::vector<Measured>& all) {
  if constexpr (applies<Method, RigidBody<Space>>) {
    if (Method::traits.default_tolerance > 0 || Method::traits.default_order == 0) return;
    for (const int order : Method::traits.orders)
      if (order > 0 && order <= 8)
        all.push_back({std::string(Method::traits.name) + std::to_string(order) + "_" + space,
                       [=] { expect_order<Method, Space>(N, order); }});
  }
}

template <class... M>
std::vector<Measured> measured(TypeList<M...>) {
  std::vector<Measured> all;
  (add<M, So3<double, true>>(3, "So3", all), ...);
  for (const int N : {3, 4, 7}) (add<M, SoN<double>>(N, "So" + std::to_string(N) + "N", all), ...);
  return all;
}

class Order : public ::testing::TestWithParam<Measured> {};
INSTANTIATE_TEST_SUITE_P(Every, Order, ::testing::ValuesIn(measured(Methods{})),
                         [](const auto& which) { return which.param.name; });
TEST_P(Order, IsTheDeclaredOne) { GetParam().measure(); }

}  // namespace
}  // namespace stiefel
