#include "tests/support/linalg/constraint_riccati_spectral.h"

#include "tests/support/linalg/right_half_subspace.h"

namespace stiefel::testing {

std::optional<Matrix<double>> constraint_riccati_spectral(const Matrix<double>& A,
                                                          const Matrix<double>& P,
                                                          const Matrix<double>& E) {
  const Eigen::Index n = A.rows();
  Matrix<double> H(2 * n, 2 * n);
  H << A, P, -E, -A.transpose();
  const auto found = right_half_subspace(H);
  if (!found) return std::nullopt;
  const Matrix<double>& Y = *found;
  return (Y + Y.transpose()) / 2;
}

}  // namespace stiefel::testing
