#include "engine/frame/discrete_stiefel.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "engine/dense/orthogonal.h"
#include "engine/frame/stiefel.h"
#include "engine/frame/stiefel_invariants.h"
#include "tests/support/integrate.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/random_frame.h"

namespace stiefel {
namespace {

using testing::RandomFrame;
using MatrixXd = Matrix<double>;
using MatrixXl = Matrix<long double>;
using Discrete = DiscreteStiefel<double>;

MatrixXd stack(const MatrixXd& top, const MatrixXd& bottom) {
  MatrixXd x(top.rows() + bottom.rows(), top.cols());
  x << top, bottom;
  return x;
}

/// The frame at time t on the geodesic.
MatrixXd geodesic(const RandomFrame<double>& frame, double t) {
  const Eigen::Index n = frame.Q.rows();
  const Stiefel<long double> system(frame.lambda.cast<long double>(), n);
  return testing::integrate(system, MatrixXl(frame.state().cast<long double>()),
                            static_cast<long double>(t))
      .topRows(n)
      .cast<double>();
}

TEST(DiscreteStiefel, ReachesTheReference) {
  const auto cases = testing::reference_cases("discrete_stiefel");
  ASSERT_EQ(cases.size(), 2);
  for (const auto& one : cases) {
    const MatrixXd Q = one.matrix("Q0");
    Discrete map(one.vector("inertia"), Q.rows());
    auto state = map.start(stack(Q, one.matrix("Q1")));
    for (int k = 0; k < static_cast<int>(one.number("steps")); ++k)
      ASSERT_TRUE(map.step(state).reached());
    const MatrixXd expected = stack(one.matrix("Q_prev"), one.matrix("Q"));
    EXPECT_LT((state.x.value - expected).cwiseAbs().maxCoeff(), 1e-12) << one.name();
  }
}

/// Started from two frames h apart on a geodesic, the map is far from the geodesic after ten steps,
/// for every h.
TEST(DiscreteStiefel, IsNotTheGeodesicFlowBelowFullRank) {
  for (const auto& [n, N] : {std::pair{1, 3}, {2, 5}, {3, 6}})
    for (const double h : {0.2, 0.02, 0.002}) {
      double sum = 0;
      for (unsigned seed = 1; seed <= 5; ++seed) {
        const RandomFrame<double> frame(n, N, seed);
        Discrete map(frame.lambda, n);
        auto state = map.start(stack(frame.Q, geodesic(frame, h)));
        for (int k = 0; k < 10; ++k) ASSERT_TRUE(map.step(state).reached());
        sum += (state.x.value.bottomRows(n) - geodesic(frame, 11 * h)).norm();
      }
      std::printf("V(%d,%d) h = %-5g  mean error after ten steps: %.2f\n", n, N, h, sum / 5);
      EXPECT_GT(sum / 5, 0.3);
    }
}

TEST(DiscreteStiefel, IsTheGeodesicFlowToSecondOrderAtFullRank) {
  const RandomFrame<double> frame(4, 4, 1);
  const auto error = [&](int steps) {
    const double h = 1.0 / steps;
    Discrete map(frame.lambda, 4);
    auto state = map.start(stack(frame.Q, geodesic(frame, h)));
    for (int k = 1; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
    return (state.x.value.bottomRows(4) - geodesic(frame, 1)).norm();
  };
  EXPECT_NEAR(std::log2(error(40) / error(80)), 2, 0.1);
}

}  // namespace
}  // namespace stiefel
