#pragma once

#include "engine/dense/decompositions.h"
#include "engine/dense/optimal_control.h"
#include "engine/motion/outside_domain.h"

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

/// Returns V − YQΛ⁻¹, KY + YK = QVᵀ + VQᵀ, K = QΛ⁻¹Qᵀ: the velocity at Q that is nearest to V in
/// the metric Λ.
template <class Scalar>
Matrix<Scalar> tangent_velocity(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                                const Matrix<Scalar>& V) {
  const Matrix<Scalar> G = Qdot_of_S(lambda, Q);
  Matrix<Scalar> Y = Q * V.transpose();
  Y += Y.transpose().eval();
  SymmetricLyapunov<Scalar> lyapunov(Q.rows());
  lyapunov.factor(G * Q.transpose());
  lyapunov.solve(Y, Y);
  return V - Y * G;
}

/// The momenta of a pair (Q, P), n × N both, on V(n, N); [ST] (45), (77)–(79). P, P_0 and S give
/// the same m and M:
///
///     m = PQᵀ − QPᵀ,   k = PQᵀ + QPᵀ  (n × n),   M = QᵀP − PᵀQ  (N × N, of rank ≤ 2n).
template <class Scalar>
Matrix<Scalar> momentum_m(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  const Matrix<Scalar> R = P * Q.transpose();
  return R - R.transpose();
}
template <class Scalar>
Matrix<Scalar> momentum_k(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  const Matrix<Scalar> R = P * Q.transpose();
  return R + R.transpose();
}

/// Returns M as an N × N matrix; only for output.
template <class Scalar>
Matrix<Scalar> dense_M(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  const Matrix<Scalar> R = Q.transpose() * P;
  return R - R.transpose();
}

/// Ξ, [ST] (81): returns P_0 = P − ½kQ, the costate with QP_0ᵀ + P_0Qᵀ = 0 and the same m and M as
/// P.
template <class Scalar>
Matrix<Scalar> Xi(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return P - momentum_k(Q, P) * Q / 2;
}

/// Returns the P_0 of an N × N matrix M, [ST] (82): P_0 = QM − ½mQ, m = QMQᵀ. A skew M is a
/// momentum at Q if (I − QᵀQ)M(I − QᵀQ) = 0; fails if that matrix has an element above
/// `tolerance`·max|M|.
template <class Scalar>
MatrixWithin<Scalar> P_0_of_M(const Matrix<Scalar>& Q, const Matrix<Scalar>& M,
                              double tolerance = 1e-8) {
  const Matrix<Scalar> QM = Q * M;
  const Matrix<Scalar> P_0 = QM - (QM * Q.transpose()) * Q / 2;
  const double left = static_cast<double>((M - dense_M(Q, P_0)).cwiseAbs().maxCoeff());
  const double bound = tolerance * static_cast<double>(M.cwiseAbs().maxCoeff());
  if (!(left <= bound)) return std::unexpected(OutsideDomain{"T*V(n, N)", left, bound});
  return P_0;
}

/// Returns S̄ = S(I − ½QᵀQ), [ST] (103). M̄ = QᵀS̄ − S̄ᵀQ = M − ½QᵀmQ (83), (100), and P_0 = QM̄.
template <class Scalar>
Matrix<Scalar> S_bar(const Matrix<Scalar>& Q, const Matrix<Scalar>& S) {
  return S - (S * Q.transpose()) * Q / 2;
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
