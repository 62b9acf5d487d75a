#include "tests/support/scenes/rigid_forms.h"

#include <cmath>

#include "engine/linalg/matrix_equations/eigenvectors.h"
#include "engine/linalg/matrix_equations/lu.h"

namespace stiefel::testing {

Eigen::MatrixXd stacked(const Eigen::MatrixXd& top, const Eigen::MatrixXd& bottom) {
  Eigen::MatrixXd x(top.rows() + bottom.rows(), top.cols());
  x << top, bottom;
  return x;
}

double operator_norm(const Eigen::MatrixXd& M) {
  const Eigen::MatrixXd square = M.transpose() * M;
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(square).eigenvalues().maxCoeff());
}

Eigen::MatrixXd symmetric_P(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& M, double epsilon) {
  const Eigen::MatrixXd K = epsilon * M;
  const Eigen::MatrixXd square =
      Eigen::MatrixXd::Identity(M.rows(), M.cols()) - K.transpose() * K / 4;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(square);
  return Q * (K / 2 + solver.operatorSqrt());
}

double epsilon_for(const Eigen::MatrixXd& M) { return 0.9 / operator_norm(M); }

Eigen::MatrixXd parametric_P(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& Y) {
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(Y.rows(), Y.cols());
  Eigen::MatrixXd root = I + Y * Y / 4, inverse = I;
  for (int k = 0; k < 20; ++k) {
    const Eigen::MatrixXd before = root;
    root = (before + inverse.inverse()) / 2;
    inverse = ((inverse + before.inverse()) / 2).eval();
  }
  return Q * (Y / 2 + root);
}

}  // namespace stiefel::testing
