#pragma once

#include "engine/linalg/lie/so_n.h"

namespace stiefel {

/// Returns the Q̇ of (Q, M), rigid body, n = N: Q̇ = QΩ, M = J(Ω) = ΛΩ + ΩΛ; [RB] §2. Needs λ_i + λ_j
/// > 0 for i ≠ j. All matrices are N × N.
template <class Scalar>
Matrix<Scalar> Qdot_of_M(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                         const Matrix<Scalar>& M) {
  Matrix<Scalar> Omega(M.rows(), M.cols());
  SoN<Scalar>::inverse_inertia(lambda, M, Omega);
  return Q * Omega;
}

}  // namespace stiefel
