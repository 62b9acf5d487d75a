#pragma once

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// Maps between (Q, M) and (Q, Q̇) of the rigid body, n = N: M = J(Ω) = ΛΩ + ΩΛ, Ω = QᵀQ̇; [RB] §2.
/// Needs λ_i + λ_j > 0 for i ≠ j. All matrices are N × N.
template <class Scalar>
Matrix<Scalar> Qdot_of_M(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                         const Matrix<Scalar>& M) {
  Matrix<Scalar> Omega = Matrix<Scalar>::Zero(M.rows(), M.cols());
  for (Eigen::Index j = 0; j < M.cols(); ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      Omega(i, j) = M(i, j) / (lambda(i) + lambda(j));
      Omega(j, i) = -Omega(i, j);
    }
  return Q * Omega;
}

template <class Scalar>
Matrix<Scalar> M_of_Qdot(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                         const Matrix<Scalar>& Qdot) {
  const Matrix<Scalar> Omega = Q.transpose() * Qdot, product = Omega * lambda.asDiagonal();
  return product - product.transpose();
}

}  // namespace stiefel
