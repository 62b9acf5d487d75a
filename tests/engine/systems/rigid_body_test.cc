#include "engine/rigid_body/body/rigid_body.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/rigid_body/body/body_invariants.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::RandomBody;
using Wide = long double;
using WideMatrix = Matrix<Wide>;

/// d/dt of f(Q, M) along the vector field, by a central difference of order 6 in extended
/// precision.
template <class F>
Wide rate(const RandomBody& body, F f) {
  RigidBody<SoN<Wide>> system(body.lambda.cast<Wide>());
  const Eigen::Index N = body.lambda.size();
  WideMatrix x(2 * N, N), dx(2 * N, N);
  x << body.Q.cast<Wide>(), body.M.cast<Wide>();
  system.field(x, dx);
  const auto at = [&](Wide t) {
    const WideMatrix y = x + t * dx;
    return f(WideMatrix(y.topRows(N)), WideMatrix(y.bottomRows(N)));
  };
  const Wide d = 1e-3L;
  return (45 * (at(d) - at(-d)) - 9 * (at(2 * d) - at(-2 * d)) + (at(3 * d) - at(-3 * d))) /
         (60 * d);
}

TEST(RigidBody, KeepsItsInvariantsInfinitesimally) {
  for (const int N : {3, 4, 6})
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const RandomBody body(N, seed);
      const Vector<Wide> lambda = body.lambda.cast<Wide>();
      EXPECT_LT(
          std::abs(rate(body, [&](const auto&, const auto& M) { return energy<Wide>(lambda, M); })),
          1e-12L);
      EXPECT_LT(std::abs(rate(body, [&](const auto& Q,
                                        const auto& M) { return (Q * M * Q.transpose())(0, 1); })),
                1e-12L);
      EXPECT_LT(std::abs(rate(
                    body, [](const auto& Q, const auto&) { return (Q.transpose() * Q)(0, 1); })),
                1e-12L);
      for (int k = 2; k <= N; ++k)
        for (int j = 0; j <= k; ++j) {
          const auto f = [&](const auto&, const auto& M) {
            return manakov<Wide>(lambda, M, k)[k][j];
          };
          EXPECT_LT(std::abs(rate(body, f)), 1e-9L * std::pow(32.0L, k)) << k << " " << j;
        }
    }
}

TEST(RigidBody, EnergyIsItsDefinition) {
  const RandomBody body(5, 3);
  Eigen::MatrixXd Omega(5, 5);
  SoN<double>::inverse_inertia(body.lambda, body.M, Omega);
  const Eigen::MatrixXd L = body.lambda.asDiagonal();
  EXPECT_NEAR(energy<double>(body.lambda, body.M), (L * Omega.transpose() * Omega).trace() / 2,
              1e-14);
  EXPECT_LT((L * Omega + Omega * L - body.M).norm(), 1e-14);
}

TEST(Manakov, CoefficientsMakeThePolynomial) {
  const RandomBody body(5, 8);
  const auto coefficients = manakov<double>(body.lambda, body.M, 5);
  const Eigen::MatrixXd L2 = body.lambda.cwiseAbs2().asDiagonal();
  for (const double mu : {-0.7, 0.0, 0.3, 1.9})
    for (int k = 1; k <= 5; ++k) {
      Eigen::MatrixXd power = Eigen::MatrixXd::Identity(5, 5);
      for (int i = 0; i < k; ++i) power = (power * (body.M + mu * L2)).eval();
      double value = 0;
      for (int j = k; j >= 0; --j) value = value * mu + coefficients[k][j];
      EXPECT_NEAR(value, power.trace(), 1e-12 * std::pow(32.0, k));
    }
}

TEST(Casimirs, AreTheEigenvaluesOfM) {
  const double w = 1.25;
  const Eigen::Matrix3d M = w * hat(Eigen::Vector3d(2, -1, 2) / 3);
  const Eigen::VectorXd c = casimirs<double>(M);
  ASSERT_EQ(c.size(), 1);
  EXPECT_NEAR(c(0), w, 1e-15);
  EXPECT_EQ(casimirs<double>(RandomBody(7, 1).M).size(), 3);
}

}  // namespace
}  // namespace stiefel
