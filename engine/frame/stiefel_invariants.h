#pragma once

#include "engine/dense/power_traces.h"

namespace stiefel {

/// Invariants on V(n, N). Frames and S are n × N. Nothing here is N × N.

/// Returns E = ½ tr(SΛ⁻¹Sᵀ), S = Q̇Λ.
template <class Scalar>
Scalar stiefel_energy(const Vector<Scalar>& lambda, const Matrix<Scalar>& S) {
  Scalar E = 0;
  for (Eigen::Index j = 0; j < S.cols(); ++j) E += S.col(j).squaredNorm() / lambda(j);
  return E / 2;
}

/// Returns m_k = Q_kΛQ_{k−1}ᵀ − Q_{k−1}ΛQ_kᵀ; [ST] (57).
template <class Scalar>
Matrix<Scalar> discrete_momentum(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q_prev,
                                 const Matrix<Scalar>& Q) {
  const Matrix<Scalar> product = Q * lambda.asDiagonal() * Q_prev.transpose();
  return product - product.transpose();
}

/// Returns the coefficients of tr L(μ)^k, k = 1..K, of the discrete Lax matrix [ST] (61),
///
///     L(μ) = Λ² + μM_k − μ²Q_{k−1}ᵀQ_{k−1},   M_k = Q_{k−1}ᵀQ_kΛ − ΛQ_kᵀQ_{k−1}.
///
/// The coefficients and the spectrum of L(μ) determine each other. Element [k − 1][j] belongs to
/// μʲ, j = 0..2k.
template <class Scalar>
std::vector<std::vector<Scalar>> discrete_lax_coefficients(const Vector<Scalar>& lambda,
                                                           const Matrix<Scalar>& Q_prev,
                                                           const Matrix<Scalar>& Q, int K) {
  const Eigen::Index n = Q.rows();
  const Matrix<Scalar> I = Matrix<Scalar>::Identity(n, n), O = Matrix<Scalar>::Zero(n, n);
  Matrix<Scalar> Z(2 * n, Q.cols()), constant(2 * n, 2 * n), linear(2 * n, 2 * n),
      quadratic(2 * n, 2 * n);
  Z << Q_prev, Q * lambda.asDiagonal();
  constant << O, O, O, O;
  linear << O, I, -I, O;
  quadratic << -I, O, O, O;
  return power_traces<Scalar>(lambda.cwiseAbs2(), 0, Z, {constant, linear, quadratic}, K);
}

/// Returns Joachimsthal's invariant of geodesics on the ellipsoid: (qᵀΛ⁻¹q)(q̇ᵀq̇).
template <class Scalar>
Scalar joachimsthal(const Vector<Scalar>& lambda, const Vector<Scalar>& q,
                    const Vector<Scalar>& qdot) {
  return q.cwiseAbs2().cwiseQuotient(lambda).sum() * qdot.squaredNorm();
}

/// Returns the coefficients of tr M(μ)^k, k = 1..K, of the Lax matrix [ST] (18) of (q, p),
///
///     M(μ) = qpᵀ − pqᵀ + μΛ + μ⁻¹ qqᵀ Δ/(qᵀΛ⁻¹q),   Δ = (pᵀΛ⁻¹q)² − (pᵀΛ⁻¹p)(qᵀΛ⁻¹q).
///
/// Element [k − 1][j] belongs to μ^{j−k}, j = 0..2k. p is any costate, for example Λq̇.
template <class Scalar>
std::vector<std::vector<Scalar>> lax_coefficients(const Vector<Scalar>& lambda,
                                                  const Vector<Scalar>& q, const Vector<Scalar>& p,
                                                  int K) {
  const Scalar qq = q.cwiseAbs2().cwiseQuotient(lambda).sum();
  const Scalar pp = p.cwiseAbs2().cwiseQuotient(lambda).sum();
  const Scalar qp = q.cwiseProduct(p).cwiseQuotient(lambda).sum();
  Matrix<Scalar> Z(2, q.size()), skew(2, 2), corner(2, 2);
  Z << q.transpose(), p.transpose();
  skew << 0, 1, -1, 0;
  corner << (qp * qp - pp * qq) / qq, 0, 0, 0;
  return power_traces<Scalar>(lambda, 2, Z, {corner, skew}, K);  // the traces of μM(μ)
}

}  // namespace stiefel
