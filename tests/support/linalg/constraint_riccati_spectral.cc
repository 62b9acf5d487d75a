#include "tests/support/linalg/constraint_riccati_spectral.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace stiefel::testing {

std::optional<Matrix<double>> constraint_riccati_spectral(const Matrix<double>& A,
                                                          const Matrix<double>& P,
                                                          const Matrix<double>& E) {
  using Complex = std::complex<double>;
  const Eigen::Index n = A.rows();
  Matrix<double> H(2 * n, 2 * n);
  H << A, P, -E, -A.transpose();
  const Eigen::EigenSolver<Matrix<double>> eigen(H);
  // Rounding moves a double eigenvalue on the imaginary axis off it by the square root of the
  // rounding unit.
  const double imaginary = 1e-7 * eigen.eigenvalues().cwiseAbs().maxCoeff();

  Matrix<Complex> chosen(2 * n, n);
  Eigen::Index found = 0;
  for (Eigen::Index i = 0; i < 2 * n; ++i) {
    const double re = eigen.eigenvalues()(i).real();
    if (-imaginary <= re && re <= imaginary) return std::nullopt;
    if (re > 0 && found < n) chosen.col(found++) = eigen.eigenvectors().col(i);
  }
  if (found != n) return std::nullopt;
  const Matrix<Complex> top = chosen.topRows(n).transpose();
  const Matrix<Complex> bottom = chosen.bottomRows(n).transpose();
  const Matrix<double> Y = top.partialPivLu().solve(bottom).transpose().real();  // bottom·top⁻¹
  return (Y + Y.transpose()) / 2;
}

}  // namespace stiefel::testing
