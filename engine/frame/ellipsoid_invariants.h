#pragma once

#include "engine/dense/power_traces.h"

namespace stiefel {

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
