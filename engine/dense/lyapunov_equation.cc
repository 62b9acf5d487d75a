#include "engine/dense/constraint_riccati.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/lyapunov_equation_of.h"

namespace stiefel {

template class Lyapunov<double>;
template class Lyapunov<long double>;
template class SymmetricLyapunov<double>;
template class SymmetricLyapunov<long double>;
template class SymmetricLyapunov<Quad>;

template class ConstraintRiccati<double>;

Vector<std::complex<double>> spectrum(const Matrix<double>& A) {
  stop_point(10 * static_cast<double>(A.rows() * A.size()));
  const Eigen::HessenbergDecomposition<Matrix<double>> reduced(A);
  const Matrix<double> T = reduced.matrixH();
  const Matrix<std::complex<double>> H = T.cast<std::complex<double>>();
  Eigen::ComplexSchur<Matrix<std::complex<double>>> schur(A.rows());
  iterate_schur(schur, H, H, false);
  return schur.matrixT().diagonal();
}

}  // namespace stiefel
