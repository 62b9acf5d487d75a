#include "tests/support/scenes/rigid_forms.h"

#include <cmath>
#include <complex>

#include "engine/dense/decompositions.h"

namespace stiefel::testing {

double operator_norm(const Eigen::MatrixXd& M) {
  return std::sqrt(symmetric_eigenvalues<double>(M.transpose() * M).maxCoeff());
}

Eigen::MatrixXd symmetric_P(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& M, double epsilon) {
  const Eigen::MatrixXd K = epsilon * M;
  const auto [w, V] =
      symmetric_eigen(Eigen::MatrixXd::Identity(M.rows(), M.cols()) - K.transpose() * K / 4);
  return Q * (K / 2 + V * w.cwiseSqrt().asDiagonal() * V.transpose());
}

double epsilon_for(const Eigen::MatrixXd& M) { return 0.9 / operator_norm(M); }

Eigen::MatrixXd parametric_P(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& Y) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(Y);
  const Eigen::MatrixXcd V = solver.eigenvectors();
  const Eigen::VectorXcd roots = solver.eigenvalues().unaryExpr(
      [](std::complex<double> y) { return y / 2.0 + std::sqrt(1.0 + y * y / 4.0); });
  const Eigen::MatrixXcd X = V * roots.asDiagonal() * V.inverse();
  return Q * X.real();
}

}  // namespace stiefel::testing
