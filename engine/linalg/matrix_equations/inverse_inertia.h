#pragma once

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// Returns Ω = J⁻¹(M), N × N: Ω_ij = M_ij/(λ_i + λ_j) for i ≠ j. Keeps the diagonal, which is 0 for
/// a skew M. Needs λ_i + λ_j > 0 for i ≠ j.
template <class Scalar>
Matrix<Scalar> inverse_inertia(const Vector<Scalar>& lambda, Matrix<Scalar> M) {
  for (Eigen::Index j = 0; j < M.cols(); ++j)
    for (Eigen::Index i = 0; i < M.rows(); ++i)
      if (i != j) M(i, j) /= lambda(i) + lambda(j);
  return M;
}

}  // namespace stiefel
