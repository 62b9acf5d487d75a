#pragma once

#include "engine/linalg/lie/so_n.h"

namespace stiefel {

/// Maps between (Q, M) and (Q, Q̇) of the rigid body, n = N: M = J(Ω) = ΛΩ + ΩΛ, Ω = QᵀQ̇; [RB] §2.
/// Needs λ_i + λ_j > 0 for i ≠ j. All matrices are N × N.
template <class Scalar>
Matrix<Scalar> Qdot_of_M(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                         const Matrix<Scalar>& M) {
  Matrix<Scalar> Omega(M.rows(), M.cols());
  SoN<Scalar>::inverse_inertia(lambda, M, Omega);
  return Q * Omega;
}

template <class Scalar>
Matrix<Scalar> M_of_Qdot(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                         const Matrix<Scalar>& Qdot) {
  const Matrix<Scalar> Omega = Q.transpose() * Qdot, product = Omega * lambda.asDiagonal();
  return product - product.transpose();
}

}  // namespace stiefel
