#pragma once

#include "engine/body/body_invariants.h"

namespace stiefel {

/// Returns A = PQᵀ, constant along every motion of the symmetric representation; [RB] (8.2). Its
/// skew part is εm/2. In the right-invariant form the constant is Q_rᵀP_r = A(Q_rᵀ, P_rᵀ)ᵀ.
template <class Scalar>
Matrix<Scalar> constant_A(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return P * Q.transpose();
}

/// Returns m_r = Q_rᵀM_rQ_r, the constant momentum of the right-invariant body; [RB] Prop. 2.1.
template <class Scalar>
Matrix<Scalar> right_momentum(const Matrix<Scalar>& Q, const Matrix<Scalar>& M) {
  return Q.transpose() * M * Q;
}

}  // namespace stiefel
