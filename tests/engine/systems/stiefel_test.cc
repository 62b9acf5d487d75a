#include "engine/frames/body/stiefel.h"

#include <gtest/gtest.h>

#include <unsupported/Eigen/AutoDiff>

#include "engine/frames/body/ellipsoid.h"
#include "engine/frames/body/ellipsoid_invariants.h"
#include "engine/frames/body/stiefel_costate.h"
#include "engine/frames/body/stiefel_invariants.h"
#include "tests/support/integrate.h"
#include "tests/support/reference_cases.h"
#include "tests/support/representations/frames.h"
#include "tests/support/scenes/random_frame.h"

namespace stiefel {
namespace {

using testing::integrate;
using testing::RandomFrame;
using Wide = long double;
using WideMatrix = Matrix<Wide>;

WideMatrix stack(const WideMatrix& top, const WideMatrix& bottom) {
  WideMatrix x(top.rows() + bottom.rows(), top.cols());
  x << top, bottom;
  return x;
}

WideMatrix some_costate(const WideMatrix& Q, const WideMatrix& S) {
  // P − S = DQ with D symmetric leaves M = QᵀP − PᵀQ as it is.
  const Eigen::Index n = Q.rows();
  WideMatrix D(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) D(i, j) = Wide(0.3) * (i + j) - Wide(0.7) + Wide(i * j);
  return S + D * Q;
}

Wide tolerance(const std::string& name) {
  return name.starts_with("ellipsoid 1:30:1000") ? 1e-9L : 1e-10L;
}

TEST(Stiefel, ReachesTheReferenceInEveryForm) {
  const auto cases = testing::reference_cases("stiefel");
  ASSERT_EQ(cases.size(), 6);
  for (const auto& one : cases) {
    const WideMatrix Q = one.matrix<Wide>("Q0"), S = one.matrix<Wide>("S0");
    const Vector<Wide> lambda = one.vector<Wide>("inertia");
    const WideMatrix inverse = lambda.cwiseInverse().asDiagonal();
    const Wide t = one.number("t"), bound = tolerance(one.name());
    const Eigen::Index n = Q.rows();

    const WideMatrix x = integrate(Stiefel<Wide>(lambda, n), stack(Q, S), t);
    const WideMatrix Q_t = one.matrix<Wide>("Q"), S_t = one.matrix<Wide>("S");
    EXPECT_LT((x.topRows(n) - Q_t).norm(), bound) << one.name();
    EXPECT_LT((x.bottomRows(n) - S_t).norm(), bound * S_t.norm()) << one.name();

    const StiefelCostate<Wide> costate(lambda, n);
    for (const WideMatrix& P : {S, some_costate(Q, S)}) {
      const WideMatrix y = integrate(costate, stack(Q, P), t);
      EXPECT_LT((y.topRows(n) - Q_t).norm(), bound) << one.name();
    }
    if (n > 1) continue;
    const WideMatrix q = integrate(Ellipsoid<Wide>(lambda), stack(Q, S * inverse), t);
    EXPECT_LT((q.topRows(1) - Q_t).norm(), bound) << one.name();
    EXPECT_LT((q.bottomRows(1) - S_t * inverse).norm(), bound * S_t.norm()) << one.name();
    const WideMatrix p = integrate(EllipsoidCostate<Wide>(lambda), stack(Q, some_costate(Q, S)), t);
    EXPECT_LT((p.topRows(1) - Q_t).norm(), bound) << one.name();
  }
}

TEST(OptimalControl, SolvesItsEquationAndIsSkew) {
  for (const int n : {1, 2, 3, 5})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const RandomFrame<Wide> frame(n, 5, seed);
      const WideMatrix P = some_costate(frame.Q, frame.S) + 2 * frame.Q.rowwise().reverse();
      OptimalControl<Wide> control(frame.lambda, n);
      control.set(frame.Q, P);
      WideMatrix U(5, 5);
      control.apply(WideMatrix::Identity(5, 5).topRows(n), U.topRows(n));
      for (int i = n; i < 5; ++i) {  // F has n rows
        WideMatrix F = WideMatrix::Zero(n, 5), FU(n, 5);
        F(0, i) = 1;
        control.apply(F, FU);
        U.row(i) = FU.row(0);
      }
      const WideMatrix L = frame.lambda.asDiagonal(), QQ = frame.Q.transpose() * frame.Q;
      const WideMatrix M = frame.Q.transpose() * P - P.transpose() * frame.Q;
      EXPECT_LT((U + U.transpose()).norm(), 1e-16L);
      EXPECT_LT((QQ * U * L + L * U * QQ - M).norm(), 1e-16L * M.norm());
    }
}

using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 1, 1>>;

/// The derivative of f along dx, exactly.
template <class F>
double rate(const Matrix<double>& x, const Matrix<double>& dx, F f) {
  Matrix<Dual> dual(x.rows(), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      dual(i, j) = Dual(x(i, j), Eigen::Matrix<double, 1, 1>(dx(i, j)));
  const Dual value = f(dual);
  return value.derivatives()(0);
}
template <class S>
Matrix<double> field(S system, const Matrix<double>& x) {
  Matrix<double> dx = x;
  system.field(x, dx);
  return dx;
}

TEST(Stiefel, KeepsItsInvariantsInfinitesimally) {
  for (const auto& [n, N] : {std::pair{1, 4}, {2, 5}, {3, 6}, {4, 4}})
    for (unsigned seed = 1; seed <= 100; ++seed) {
      const RandomFrame<double> frame(n, N, seed);
      const Vector<Dual> lambda = frame.lambda.cast<Dual>();
      const auto top = [n = n](const auto& x) { return Matrix<Dual>(x.topRows(n)); };
      const auto bottom = [n = n](const auto& x) { return Matrix<Dual>(x.bottomRows(n)); };
      const int last = n - 1;

      const Matrix<double> x = frame.state(), dx = field(Stiefel<double>(frame.lambda, n), x);
      EXPECT_LT(std::abs(rate(
                    x, dx, [&](const auto& y) { return stiefel_energy<Dual>(lambda, bottom(y)); })),
                1e-14);
      EXPECT_LT(std::abs(rate(x, dx,
                              [&](const auto& y) {
                                return frame_momentum<Dual>(top(y), bottom(y))(0, last);
                              })),
                1e-14);
      EXPECT_LT(
          std::abs(rate(x, dx, [&](const auto& y) { return top(y).row(0).dot(top(y).row(last)); })),
          1e-14);

      Matrix<double> z = x;
      z.bottomRows(n) =
          some_costate(frame.Q.cast<Wide>(), frame.S.cast<Wide>()).template cast<double>();
      const Matrix<double> dz = field(StiefelCostate<double>(frame.lambda, n), z);
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          EXPECT_LT(std::abs(rate(z, dz,
                                  [&](const auto& y) {
                                    return costate_product<Dual>(top(y), bottom(y))(i, j);
                                  })),
                    1e-13);
    }
}

TEST(Stiefel, SIsNoCostateOfItsOwn) {
  const RandomFrame<double> frame(2, 5, 1);
  EXPECT_GT(momentum_k<double>(frame.Q, frame.S).norm(), 1e-2);
  const Matrix<double> x = frame.state(), dx = field(Stiefel<double>(frame.lambda, 2), x);
  EXPECT_GT(std::abs(rate(x, dx,
                          [](const auto& y) {
                            return momentum_k<Dual>(Matrix<Dual>(y.topRows(2)),
                                                    Matrix<Dual>(y.bottomRows(2)))(0, 0);
                          })),
            1e-3);
}

Vector<Dual> row(const Matrix<Dual>& x, Eigen::Index i) { return x.row(i).transpose(); }

TEST(Ellipsoid, KeepsItsInvariantsInfinitesimally) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const RandomFrame<double> frame(1, 4, seed);
    const Vector<Dual> lambda = frame.lambda.cast<Dual>();
    Matrix<double> x = frame.state();
    x.row(1) = x.row(1).cwiseQuotient(frame.lambda.transpose());
    const Matrix<double> dx = field(Ellipsoid<double>(frame.lambda), x);
    EXPECT_LT(
        std::abs(
            rate(x, dx, [&](const auto& y) { return joachimsthal(lambda, row(y, 0), row(y, 1)); })),
        1e-14);
    double closest = 1;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j)
        closest = std::min(closest, std::abs(frame.lambda(i) - frame.lambda(j)));
    for (int k = 0; k < 4; ++k)
      EXPECT_LT(std::abs(rate(x, dx,
                              [&](const auto& y) {
                                return testing::uhlenbeck(lambda, row(y, 0), row(y, 1))(k);
                              })),
                1e-13 / closest);

    Matrix<double> z = x;
    z.row(1) = frame.S + (0.3 + 0.01 * seed) * frame.Q;
    const Matrix<double> dz = field(EllipsoidCostate<double>(frame.lambda), z);
    for (int k = 1; k <= 4; ++k)
      for (int j = 0; j <= 2 * k; ++j)
        EXPECT_LT(std::abs(rate(z, dz,
                                [&](const auto& y) {
                                  return lax_coefficients<Dual>(lambda, row(y, 0), row(y, 1),
                                                                k)[k - 1][j];
                                })),
                  1e-14 * std::pow(8.0, k))
            << k << " " << j;
  }
}

TEST(Ellipsoid, InvariantsAreTheirDefinitions) {
  const RandomFrame<double> frame(1, 5, 3);
  const Vector<double> q = frame.Q.transpose(), p = frame.S.transpose() + 0.4 * q;
  const Vector<double> qdot = frame.S.transpose().cwiseQuotient(frame.lambda);
  EXPECT_NEAR(testing::uhlenbeck(frame.lambda, q, qdot).sum(),
              2 * stiefel_energy<double>(frame.lambda, frame.S), 1e-13);
  const Eigen::MatrixXd inverse = frame.lambda.cwiseInverse().asDiagonal();
  const double qq = q.dot(inverse * q), pp = p.dot(inverse * p), qp = q.dot(inverse * p);
  const auto coefficients = lax_coefficients<double>(frame.lambda, q, p, 5);
  for (const double mu : {-0.8, 0.3, 1.7}) {
    const Eigen::MatrixXd skew = q * p.transpose() - p * q.transpose();
    const Eigen::MatrixXd corner = q * q.transpose() * ((qp * qp - pp * qq) / qq);
    Eigen::MatrixXd M = skew + corner / mu, power = Eigen::MatrixXd::Identity(5, 5);
    M.diagonal() += mu * frame.lambda;
    for (int k = 1; k <= 5; ++k) {
      power = (power * M).eval();
      double value = 0, size = 0;
      for (int j = 0; j <= 2 * k; ++j) {
        value += coefficients[k - 1][j] * std::pow(mu, j - k);
        size += std::abs(coefficients[k - 1][j]) * std::pow(std::abs(mu), j - k);
      }
      EXPECT_NEAR(value, power.trace(), 1e-13 * size) << k;
    }
  }
}

}  // namespace
}  // namespace stiefel
