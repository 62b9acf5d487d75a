#include "engine/linalg/matrix_equations/stein.h"

#include <Eigen/Eigenvalues>

namespace stiefel {

SteinEquation::SteinEquation(const Matrix<double>& R) {
  const Eigen::ComplexSchur<Eigen::MatrixXcd> schur(R.cast<std::complex<double>>());
  Z_ = schur.matrixU();
  d_ = schur.matrixT().diagonal();  // R is normal: T is diagonal
}

Matrix<double> SteinEquation::solve(const Matrix<double>& G) const {
  Eigen::MatrixXcd Y = Z_.adjoint() * G.cast<std::complex<double>>() * Z_;
  for (Eigen::Index j = 0; j < Y.cols(); ++j)
    for (Eigen::Index i = 0; i < Y.rows(); ++i) Y(i, j) /= 1.0 + d_(i) * d_(j);
  return (Z_ * Y * Z_.adjoint()).real();
}

}  // namespace stiefel
