#include "engine/frame/stiefel.h"

#include <gtest/gtest.h>

#include <unsupported/Eigen/AutoDiff>
#include "engine/frame/stiefel_costate.h"
#include "engine/frame/stiefel_invariants.h"
#include "tests/support/integrate.h"
#include "tests/support/reference_cases.h"
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

}  // namespace
}  // namespace stiefel
