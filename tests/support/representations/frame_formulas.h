#pragma once

#include "engine/frame/stiefel_momenta.h"

/// Formulas on V(n, N) that the engine does not need, for tests of those that it has.
namespace stiefel::testing {

/// Returns the product VM for V with N columns and few rows, in O(Nn) operations without an N × N
/// matrix.
template <class Scalar>
Matrix<Scalar> times_M(const Matrix<Scalar>& V, const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return (V * Q.transpose()) * P - (V * P.transpose()) * Q;
}

/// Inverts Ξ on W^k: returns P = P_0 + ½kQ, k symmetric n × n.
template <class Scalar>
Matrix<Scalar> Xi_inverse(const Matrix<Scalar>& Q, const Matrix<Scalar>& P_0,
                          const Matrix<Scalar>& k) {
  return P_0 + k * Q / 2;
}

/// Returns the distance of S from T*V(n, N), where Q̇Qᵀ is skew: max |QΛ⁻¹Sᵀ + SΛ⁻¹Qᵀ|.
template <class Scalar>
Scalar tangency_defect(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                       const Matrix<Scalar>& S) {
  return momentum_k<Scalar>(Q, Qdot_of_S(lambda, S)).cwiseAbs().maxCoeff();
}

/// Returns the distance of P from W⁰: max |QPᵀ + PQᵀ|.
template <class Scalar>
Scalar costate_defect(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return momentum_k(Q, P).cwiseAbs().maxCoeff();
}

}  // namespace stiefel::testing
