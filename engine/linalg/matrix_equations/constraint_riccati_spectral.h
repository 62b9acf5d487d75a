#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <optional>

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// Reference solver of E + YA + AᵀY + YPY = 0 with spec(A + PY) in Re > 0: [I; Y] spans the
/// eigenvectors of [[A, P], [−E, −Aᵀ]] whose eigenvalues have Re > 0. The spectrum is symmetric
/// about the imaginary axis. Returns nothing when an eigenvalue lies on that axis: then there is no
/// solution.
template <class Scalar>
std::optional<Matrix<Scalar>> constraint_riccati_spectral(const Matrix<Scalar>& A,
                                                          const Matrix<Scalar>& P,
                                                          const Matrix<Scalar>& E) {
  using Complex = std::complex<Scalar>;
  const Eigen::Index n = A.rows();
  Matrix<Scalar> H(2 * n, 2 * n);
  H << A, P, -E, -A.transpose();
  const Eigen::EigenSolver<Matrix<Scalar>> eigen(H);
  // Rounding moves a double eigenvalue on the imaginary axis off it by the square root of the
  // rounding unit.
  const Scalar imaginary = Scalar(1e-7) * eigen.eigenvalues().cwiseAbs().maxCoeff();

  Matrix<Complex> chosen(2 * n, n);
  Eigen::Index found = 0;
  for (Eigen::Index i = 0; i < 2 * n; ++i) {
    const Scalar re = eigen.eigenvalues()(i).real();
    if (-imaginary <= re && re <= imaginary) return std::nullopt;
    if (re > 0 && found < n) chosen.col(found++) = eigen.eigenvectors().col(i);
  }
  if (found != n) return std::nullopt;
  const Matrix<Complex> top = chosen.topRows(n).transpose();
  const Matrix<Complex> bottom = chosen.bottomRows(n).transpose();
  const Matrix<Scalar> Y = top.partialPivLu().solve(bottom).transpose().real();  // bottom·top⁻¹
  return (Y + Y.transpose()) / 2;
}

}  // namespace stiefel
