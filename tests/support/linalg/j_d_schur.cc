#include "tests/support/linalg/j_d_schur.h"

#include "tests/support/linalg/right_half_subspace.h"

namespace stiefel::testing {

std::optional<Matrix<double>> J_D_inverse_schur(const Vector<double>& lambda,
                                                const Matrix<double>& K) {
  const Eigen::Index N = lambda.size();
  Matrix<double> H(2 * N, 2 * N), square = K * K / 4;
  square.diagonal() += lambda.cwiseAbs2();
  H << K / 2, Matrix<double>::Identity(N, N), square, K / 2;
  const auto found = right_half_subspace(H);
  if (!found) return std::nullopt;
  const Matrix<double>& S = *found;
  return ((S + S.transpose()) / 2 + K / 2) * lambda.cwiseInverse().asDiagonal();
}

}  // namespace stiefel::testing
