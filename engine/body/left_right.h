#pragma once

#include "engine/body/psi.h"

namespace stiefel {

// The right-invariant rigid body has Q_r = Qᵀ, M_r = −M ([RB] Prop. 2.1), P_r = Pᵀ (Prop. 3.4).

/// The right-invariant Ψ: returns M_r = (P_rQ_rᵀ − Q_rP_rᵀ)/ε.
template <class Scalar>
Matrix<Scalar> Psi_right(const Matrix<Scalar>& Q, const Matrix<Scalar>& P, Scalar epsilon = 1) {
  const Matrix<Scalar> R = P * Q.transpose();
  return (R - R.transpose()) / epsilon;
}

/// The inverse of the right-invariant Ψ, [RB] (3.4): returns P_r = exp(asinh(εM_r/2)) Q_r,
/// ‖εM_r‖_op < 2.
template <class Scalar>
MatrixWithin<Scalar> Psi_right_inverse(const Matrix<Scalar>& Q, const Matrix<Scalar>& M,
                                       Scalar epsilon = 1) {
  auto E = exp_asinh<Scalar>(epsilon * M / 2);
  if (E) *E = (*E * Q).eval();
  return E;
}

}  // namespace stiefel
