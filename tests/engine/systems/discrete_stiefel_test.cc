#include "engine/frames/body/discrete_stiefel.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "engine/frames/body/stiefel.h"
#include "engine/frames/body/stiefel_invariants.h"
#include "engine/linalg/lie/orthogonal.h"
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

TEST(DiscreteStiefel, SolvesItsEquation) {
  const RandomFrame<double> frame(3, 6, 2);
  Discrete map(frame.lambda, 3);
  auto state = map.start(stack(frame.Q, geodesic(frame, 0.3)));
  const MatrixXd Q_prev = state.x.value.topRows(3), Q = state.x.value.bottomRows(3);
  ASSERT_TRUE(map.step(state).reached());
  EXPECT_EQ(state.x.value.topRows(3), Q);
  const MatrixXd next = state.x.value.bottomRows(3);
  const MatrixXd sum = (next + Q_prev) * frame.lambda.asDiagonal();
  const MatrixXd B = sum * Q.transpose();
  EXPECT_LT((B - B.transpose()).norm(), 1e-13);
  EXPECT_LT((sum - B * Q).norm(), 1e-13);
  EXPECT_LT(orthogonality_defect(next), 1e-14);
}

TEST(DiscreteStiefel, KeepsItsInvariants) {
  for (const auto& [n, N] : {std::pair{1, 4}, {2, 5}, {3, 5}}) {
    const RandomFrame<double> frame(n, N, 3);
    Discrete map(frame.lambda, n);
    auto state = map.start(stack(frame.Q, geodesic(frame, 0.3)));
    const auto of = [&, n = n](auto function) {
      return function(MatrixXd(state.x.value.topRows(n)), MatrixXd(state.x.value.bottomRows(n)));
    };
    const auto momentum = [&](const MatrixXd& Q_prev, const MatrixXd& Q) {
      return discrete_momentum<double>(frame.lambda, Q_prev, Q);
    };
    const auto lax = [&](const MatrixXd& Q_prev, const MatrixXd& Q) {
      return discrete_lax_coefficients<double>(frame.lambda, Q_prev, Q, 4);
    };
    const MatrixXd m = of(momentum);
    const auto coefficients = of(lax);
    for (int k = 0; k < 20'000; ++k) ASSERT_TRUE(map.step(state).reached());
    EXPECT_LT((of(momentum) - m).norm(), 1e-12);
    EXPECT_LT(orthogonality_defect(state.x.value.bottomRows(n)), 1e-13);
    const auto now = of(lax);
    for (std::size_t k = 0; k < now.size(); ++k)
      for (std::size_t j = 0; j < now[k].size(); ++j)
        EXPECT_LT(std::abs(now[k][j] - coefficients[k][j]), 1e-13 * N * std::pow(32.0, k + 1))
            << n << " " << k << " " << j;
  }
}

TEST(DiscreteLax, CoefficientsMakeThePolynomial) {
  const RandomFrame<double> frame(2, 5, 6);
  const MatrixXd Q_prev = frame.Q, Q = geodesic(frame, 0.4), L = frame.lambda.asDiagonal();
  const auto coefficients = discrete_lax_coefficients<double>(frame.lambda, Q_prev, Q, 5);
  const MatrixXd M = Q_prev.transpose() * Q * L - L * Q.transpose() * Q_prev;
  for (const double mu : {-0.7, 0.0, 0.4, 1.9}) {
    const MatrixXd L_mu = L * L + mu * M - mu * mu * Q_prev.transpose() * Q_prev;
    MatrixXd power = MatrixXd::Identity(5, 5);
    for (int k = 1; k <= 5; ++k) {
      power = (power * L_mu).eval();
      double value = 0, size = 0;
      for (int j = 2 * k; j >= 0; --j) {
        value = value * mu + coefficients[k - 1][j];
        size = size * std::abs(mu) + std::abs(coefficients[k - 1][j]);
      }
      EXPECT_NEAR(value, power.trace(), 1e-13 * size);
    }
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
