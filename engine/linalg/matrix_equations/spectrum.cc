#include "engine/linalg/matrix_equations/spectrum.h"

#include "engine/linalg/matrix_equations/stoppable_schur.h"
#include "stiefel/stop.h"

namespace stiefel {

Vector<std::complex<double>> spectrum(const Matrix<double>& A) {
  stop_point(25 * static_cast<double>(A.rows() * A.size()));
  return Eigen::EigenSolver<Matrix<double>>(A, false).eigenvalues();
}

}  // namespace stiefel
