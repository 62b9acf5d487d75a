#include "engine/linalg/matrix_equations/stein.h"

#include "engine/linalg/matrix_equations/stoppable_schur.h"
#include "stiefel/stop.h"

namespace stiefel {

SteinEquation::SteinEquation(const Matrix<double>& R) {
  stop_point(80 * static_cast<double>(R.rows() * R.size()));
  const Eigen::ComplexSchur<Eigen::MatrixXcd> schur(R.cast<std::complex<double>>());
  Z_ = schur.matrixU();
  d_ = schur.matrixT().diagonal();  // R is normal: T is diagonal
}

Matrix<double> SteinEquation::solve(const Matrix<double>& G) const {
  stop_point(8 * static_cast<double>(G.rows() * G.size()));
  Eigen::MatrixXcd Y = Z_.adjoint() * G.cast<std::complex<double>>() * Z_;
  for (Eigen::Index j = 0; j < Y.cols(); ++j)
    for (Eigen::Index i = 0; i < Y.rows(); ++i) Y(i, j) /= 1.0 + d_(i) * d_(j);
  stop_point(8 * static_cast<double>(G.rows() * G.size()));
  return (Z_ * Y * Z_.adjoint()).real();
}

}  // namespace stiefel
