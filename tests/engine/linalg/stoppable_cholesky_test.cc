#include "engine/linalg/matrix_equations/stoppable_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <stop_token>

#include "engine/linalg/matrix_equations/eigenvectors.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::MatrixXd;

MatrixXd positive(Eigen::Index size) {
  const MatrixXd A = MatrixXd::Random(size, size);
  return A * A.transpose() + MatrixXd::Identity(size, size);
}

TEST(StoppableCholesky, HasTheBitsOfEigen) {
  for (const Eigen::Index size : {1, 7, 31, 32, 100, 200, 300}) {
    const MatrixXd A = positive(size);
    MatrixXd L = A.triangularView<Eigen::Lower>();
    ASSERT_TRUE(factor_positive(L)) << size;
    const MatrixXd expected = A.llt().matrixL();
    EXPECT_TRUE(L == expected) << size;
    const MatrixXd B = MatrixXd::Random(size, 70);
    MatrixXd X = B;
    divide_by_lower(L, X);
    EXPECT_LT((L * X - B).cwiseAbs().maxCoeff(), 1e-12) << size;
  }
}

TEST(StoppableCholesky, RefusesWhatIsNotPositive) {
  for (const Eigen::Index size : {1, 40, 300})
    for (const Eigen::Index at : {Eigen::Index{0}, size / 2, size - 1}) {
      MatrixXd A = positive(size);
      A(at, at) = -1;
      EXPECT_FALSE(factor_positive(A)) << size << " " << at;
    }
}

/// 1265 equations are those of 23 inner frames with 10 rows.
TEST(StoppableCholesky, LooksAtTheTokenBeforeEachBlock) {
  const std::stop_token never;
  MatrixXd A = positive(1265);
  {
    const StopScope scope(never);
    ASSERT_TRUE(factor_positive(A));
    EXPECT_GE(scope.looks(), 10);
  }
  std::stop_source source;
  source.request_stop();
  const std::stop_token at_once = source.get_token();
  const StopScope scope(at_once);
  EXPECT_THROW(factor_positive(A), Stopped);
}

TEST(StoppableEigenvectors, LookAtTheTokenBeforeEachColumn) {
  const std::stop_token never;
  const MatrixXd A = positive(60);
  const StopScope scope(never);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(A);
  EXPECT_GE(scope.looks(), 2 * 60 - 2);
  const MatrixXd rest =
      A * solver.eigenvectors() - solver.eigenvectors() * solver.eigenvalues().asDiagonal();
  EXPECT_LT(rest.norm(), 1e-12 * A.norm());
}

}  // namespace
}  // namespace stiefel
