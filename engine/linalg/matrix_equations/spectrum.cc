#include "engine/linalg/matrix_equations/spectrum.h"

#include <Eigen/Eigenvalues>

namespace stiefel {

Vector<std::complex<double>> spectrum(const Matrix<double>& A) {
  return Eigen::EigenSolver<Matrix<double>>(A, false).eigenvalues();
}

}  // namespace stiefel
