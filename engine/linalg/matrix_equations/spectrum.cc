#include "engine/linalg/matrix_equations/spectrum.h"

#include "engine/linalg/matrix_equations/decompositions.h"
#include "engine/linalg/matrix_equations/stoppable_schur.h"
#include "stiefel/stop.h"

namespace stiefel {

Vector<std::complex<double>> spectrum(const Matrix<double>& A) {
  stop_point(25 * static_cast<double>(A.rows() * A.size()));
  return Eigen::EigenSolver<Matrix<double>>(A, false).eigenvalues();
}

Matrix<double> principal_root(const Matrix<double>& A) {
  constexpr int most = 60;
  const Matrix<double> I = Matrix<double>::Identity(A.rows(), A.cols());
  Matrix<double> X = A, Y = I;
  for (int k = 0; k < most; ++k) {
    stop_point(3 * static_cast<double>(A.rows() * A.size()));
    const Matrix<double> next = (X + Eigen::PartialPivLU<Matrix<double>>(Y).solve(I)) / 2;
    stop_point();
    Y = ((Y + Eigen::PartialPivLU<Matrix<double>>(X).solve(I)) / 2).eval();
    const double change = (next - X).cwiseAbs().maxCoeff();
    X = next;
    if (!(change > 1e-15 * X.cwiseAbs().maxCoeff())) break;
  }
  return X;
}

}  // namespace stiefel
