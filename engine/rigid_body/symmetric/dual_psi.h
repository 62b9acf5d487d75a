#pragma once

#include "engine/linalg/matrix_equations/dual_equations.h"
#include "engine/rigid_body/symmetric/psi.h"

namespace stiefel {

/// X = (I + A²)^{1/2} of a skew A in dual numbers: XX′ + X′X = AA′ + A′A.
template <class Real, int lanes>
MatrixWithin<Dual<Real, lanes>> root_of_one_plus_square(const Matrix<Dual<Real, lanes>>& A) {
  const MatrixWithin<Real> root = root_of_one_plus_square<Real>(values_of(A));
  if (!root) return std::unexpected(root.error());
  const Matrix<Dual<Real, lanes>> square = A * A;
  Matrix<Dual<Real, lanes>> X = root->template cast<Dual<Real, lanes>>();
  SymmetricLyapunov<Real> lyapunov(A.rows());
  lyapunov.factor(*root);
  for (int k = 0; k < lanes; ++k) {
    Matrix<Real> part = lane_of(square, k);
    lyapunov.solve(part, part);
    set_lane(X, k, part);
  }
  return X;
}

/// ‖M‖_op of the values. Only the choice of ε depends on it, and steps of (Q, M) do not depend on
/// ε.
template <class Real, int lanes>
Dual<Real, lanes> skew_norm(const Matrix<Dual<Real, lanes>>& M) {
  return skew_norm<Real>(values_of(M));
}

}  // namespace stiefel
