#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// The two-forms of both papers on pairs u, v of tangent vectors. A tangent vector is stacked like
/// the state, two blocks of n × N each. All forms are bilinear and skew. The arguments are not
/// checked.

/// tr(AᵀB).
template <class A, class B>
typename A::Scalar trace_product(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return a.cwiseProduct(b).sum();
}

/// ω on T*SO(N), left-trivialised, [RB] (3.13): at (Q, M), for u = (Qξ_1, Z_1), v = (Qξ_2, Z_2) and
/// ⟨ξ, η⟩ = −½ tr(ξη),
///
///     ω = ⟨Z_2, ξ_1⟩ − ⟨Z_1, ξ_2⟩ + ⟨M, [ξ_1, ξ_2]⟩.
template <class Scalar>
Scalar omega_canonical(const Matrix<Scalar>& x, const Matrix<Scalar>& u, const Matrix<Scalar>& v) {
  const Eigen::Index N = x.cols();
  const Matrix<Scalar> xi_1 = x.topRows(N).transpose() * u.topRows(N);
  const Matrix<Scalar> xi_2 = x.topRows(N).transpose() * v.topRows(N);
  const Matrix<Scalar> bracket = xi_1 * xi_2 - xi_2 * xi_1;
  return (trace_product(v.bottomRows(N), xi_1) - trace_product(u.bottomRows(N), xi_2) +
          trace_product(x.bottomRows(N), bracket)) /
         2;  // ⟨ξ, η⟩ = ½ tr(ξᵀη)
}

/// ω on pairs of n × N matrices, [ST] (63), (71), for u = (A_1, A_2), v = (B_1, B_2): tr(A_1ᵀB_2) −
/// tr(A_2ᵀB_1). Its restrictions to W^k (Theorem 3) and to T*V(n, N) ∋ (Q, S), where it is −d⟨S,
/// dQ⟩, are symplectic.
template <class Scalar>
Scalar omega_pairs(const Matrix<Scalar>& u, const Matrix<Scalar>& v) {
  const Eigen::Index n = u.rows() / 2;
  return trace_product(u.topRows(n), v.bottomRows(n)) -
         trace_product(u.bottomRows(n), v.topRows(n));
}

/// Ω_gl on gl(N) × gl(N), [RB] (3.5), for u = (ξ_1, η_1), v = (ξ_2, η_2): ½ tr(η_2ᵀξ_1 − η_1ᵀξ_2).
/// On S ⊂ SO(N) × SO(N), tangent vectors (Qξ, Pη), it is symplectic (Prop. 3.9).
template <class Scalar>
Scalar Omega_gl(const Matrix<Scalar>& u, const Matrix<Scalar>& v) {
  return omega_pairs(u, v) / 2;
}

/// Ω_L on SO(N) × SO(N) ∋ (Q_{k−1}, Q_k), [RB] (7.8), of L = tr(Q_{k−1}ΛQ_kᵀ), for u = (Q_{k−1}ξ_1,
/// Q_kη_1) and v = (Q_{k−1}ξ_2, Q_kη_2): ½ tr(Q_kᵀQ_{k−1}(ξ_2Λη_1 − ξ_1Λη_2)), which is ½
/// tr(u_1Λv_2ᵀ − v_1Λu_2ᵀ). Symplectic on E_L (Theorem 7.2); for Λ = I it is Ω_gl.
template <class Scalar>
Scalar Omega_L(const Vector<Scalar>& lambda, const Matrix<Scalar>& u, const Matrix<Scalar>& v) {
  return omega_pairs<Scalar>(u * lambda.asDiagonal(), v) / 2;
}

/// ω_c on T*V(n, N) ∋ (Q, QM̄), [ST] (93), for u = (QU_1, QZ_1), v = (QU_2, QZ_2) with skew U, Z:
///
///     ω_c = ⟨QU_2M̄ + QZ_2, QU_1⟩ − ⟨QU_1M̄ + QZ_1, QU_2⟩,   ⟨A, B⟩ = tr(AᵀB),
///
/// M̄ = QᵀS̄ − S̄ᵀQ given by its factors, the state x = (Q, S̄) ([ST] (103)). No N × N matrix.
template <class Scalar>
Scalar omega_cotangent(const Matrix<Scalar>& x, const Matrix<Scalar>& u, const Matrix<Scalar>& v) {
  const Eigen::Index n = x.rows() / 2;
  const auto Q = x.topRows(n), S_bar = x.bottomRows(n);
  const auto times_M_bar = [&](const Matrix<Scalar>& V) -> Matrix<Scalar> {
    return (V * Q.transpose()) * S_bar - (V * S_bar.transpose()) * Q;
  };
  const Matrix<Scalar> first = times_M_bar(u.topRows(n)) + u.bottomRows(n);
  const Matrix<Scalar> second = times_M_bar(v.topRows(n)) + v.bottomRows(n);
  return trace_product(second, u.topRows(n)) - trace_product(first, v.topRows(n));
}

}  // namespace stiefel
