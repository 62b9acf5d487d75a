#pragma once

#include "engine/dense/optimal_control.h"
#include "engine/frame/stiefel_momenta.h"

namespace stiefel {

/// Maps between (Q, Q̇) and (Q, S) on V(n, N): S = Q̇Λ, [ST] (27), (41), so Q̇ = SΛ⁻¹. All matrices
/// are n × N. (Erratum: the paper also prints S = Q̇Λ⁻¹.)
template <class Scalar>
Matrix<Scalar> S_of_Qdot(const Vector<Scalar>& lambda, const Matrix<Scalar>& Qdot) {
  return Qdot * lambda.asDiagonal();
}
template <class Scalar>
Matrix<Scalar> Qdot_of_S(const Vector<Scalar>& lambda, const Matrix<Scalar>& S) {
  return S * lambda.cwiseInverse().asDiagonal();
}

/// 𝔐: T*V(n, N) → W⁰, [ST] Prop. 6, (90), (91): returns P_0 = S + DQ, D = −½(QSᵀ + SQᵀ), which is Ξ
/// applied to S.
template <class Scalar>
Matrix<Scalar> Legendre(const Matrix<Scalar>& Q, const Matrix<Scalar>& S) {
  return Xi(Q, S);
}

/// 𝔐⁻¹, [ST] (92), and (Q, P) ↦ (Q, S) for every other P with the same M:
///
///     S = QUΛ = P − ((QΛ⁻¹Pᵀ)G − KX)Q.
template <class Scalar>
Matrix<Scalar> Legendre_inverse(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                                const Matrix<Scalar>& P) {
  OptimalControl<Scalar> U(lambda, Q.rows());
  Matrix<Scalar> Qdot(Q.rows(), Q.cols());
  U.set(Q, P);
  U.apply(Q, Qdot);
  return Qdot * lambda.asDiagonal();
}

}  // namespace stiefel
