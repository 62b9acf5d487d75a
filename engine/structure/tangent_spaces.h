#pragma once

#include "engine/dense/decompositions.h"

namespace stiefel {

/// The two-forms of both papers and the symplectic manifolds on which the systems live. A state is
/// two n × N blocks, one above the other, and a tangent vector is stacked like it. All forms are
/// bilinear and skew; arguments are not checked. Each space has `form(x, u, v)` and `tangent(x,
/// G)`, which returns a tangent vector at the state x from any matrix G of x's shape; this map is
/// linear in G and onto.

/// tr(AᵀB).
template <class A, class B>
typename A::Scalar trace_product(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return a.cwiseProduct(b).sum();
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

/// Returns the part Qξ of G, ξ skew, that is tangent to QQᵀ = I_n, for every n ≤ N, without an N ×
/// N matrix.
template <class Scalar>
Matrix<Scalar> tangent_to_frames(const Matrix<Scalar>& Q, const Matrix<Scalar>& G) {
  const Matrix<Scalar> R = G * Q.transpose();
  return G - (R + R.transpose()) * Q / 2;
}

template <class Scalar>
Matrix<Scalar> stacked_pair(const Matrix<Scalar>& top, const Matrix<Scalar>& bottom) {
  Matrix<Scalar> x(top.rows() + bottom.rows(), top.cols());
  x << top, bottom;
  return x;
}

/// Two frames, one above the other.
template <class Scalar>
Matrix<Scalar> tangent_to_pairs(const Matrix<Scalar>& x, const Matrix<Scalar>& G) {
  const Eigen::Index n = x.rows() / 2;
  return stacked_pair<Scalar>(tangent_to_frames<Scalar>(x.topRows(n), G.topRows(n)),
                              tangent_to_frames<Scalar>(x.bottomRows(n), G.bottomRows(n)));
}

/// (Q, M) ∈ T*SO(N) with ω, left-trivialised, [RB] (3.13): for u = (Qξ_1, Z_1), v = (Qξ_2, Z_2) and
/// ⟨ξ, η⟩ = −½ tr(ξη),
///
///     ω = ⟨Z_2, ξ_1⟩ − ⟨Z_1, ξ_2⟩ + ⟨M, [ξ_1, ξ_2]⟩.
template <class Scalar>
struct CotangentOfRotations {
  Matrix<Scalar> tangent(const Matrix<Scalar>& x, const Matrix<Scalar>& G) const {
    const Matrix<Scalar> Z = G.bottomRows(x.cols());
    return stacked_pair<Scalar>(tangent_to_frames<Scalar>(x.topRows(x.cols()), G.topRows(x.cols())),
                                (Z - Z.transpose()) / 2);
  }
  Scalar form(const Matrix<Scalar>& x, const Matrix<Scalar>& u, const Matrix<Scalar>& v) const {
    const Eigen::Index N = x.cols();
    const Matrix<Scalar> xi_1 = x.topRows(N).transpose() * u.topRows(N);
    const Matrix<Scalar> xi_2 = x.topRows(N).transpose() * v.topRows(N);
    const Matrix<Scalar> bracket = xi_1 * xi_2 - xi_2 * xi_1;
    return (trace_product(v.bottomRows(N), xi_1) - trace_product(u.bottomRows(N), xi_2) +
            trace_product(x.bottomRows(N), bracket)) /
           2;  // ⟨ξ, η⟩ = ½ tr(ξᵀη)
  }
};

/// (Q_{k−1}, Q_k) ∈ E_L ⊂ SO(N) × SO(N) with Ω_L, [RB] (7.8), of L = tr(Q_{k−1}ΛQ_kᵀ), for u =
/// (Q_{k−1}ξ_1, Q_kη_1) and v = (Q_{k−1}ξ_2, Q_kη_2): ½ tr(Q_kᵀQ_{k−1}(ξ_2Λη_1 − ξ_1Λη_2)), which
/// is ½ tr(u_1Λv_2ᵀ − v_1Λu_2ᵀ). Symplectic on E_L (Theorem 7.2). For Λ = I it is Ω_gl, [RB] (3.5),
/// ½ tr(η_2ᵀξ_1 − η_1ᵀξ_2) of (ξ_i, η_i), on (Q, P) ∈ S ⊂ SO(N) × SO(N), where it is symplectic
/// (Prop. 3.9).
template <class Scalar>
struct PairsOfRotations {
  Vector<Scalar> lambda;

  Matrix<Scalar> tangent(const Matrix<Scalar>& x, const Matrix<Scalar>& G) const {
    return tangent_to_pairs(x, G);
  }
  Scalar form(const Matrix<Scalar>&, const Matrix<Scalar>& u, const Matrix<Scalar>& v) const {
    return omega_pairs<Scalar>(u * lambda.asDiagonal(), v) / 2;
  }
};

/// (Q, P) ∈ W^k, [ST] (64), with (63): QQᵀ = I_n, QPᵀ + PQᵀ = k.
template <class Scalar>
struct CostatesOfFrames {
  Matrix<Scalar> tangent(const Matrix<Scalar>& x, const Matrix<Scalar>& G) const {
    const Eigen::Index n = x.rows() / 2;
    const auto Q = x.topRows(n), P = x.bottomRows(n);
    const Matrix<Scalar> A = tangent_to_frames<Scalar>(Q, G.topRows(n));
    const Matrix<Scalar> R = G.bottomRows(n) * Q.transpose() + A * P.transpose();
    return stacked_pair<Scalar>(A, G.bottomRows(n) - (R + R.transpose()) * Q / 2);
  }
  Scalar form(const Matrix<Scalar>&, const Matrix<Scalar>& u, const Matrix<Scalar>& v) const {
    return omega_pairs(u, v);
  }
};

/// (Q, S) ∈ T*V(n, N) with (63): QQᵀ = I_n, QΛ⁻¹Sᵀ + SΛ⁻¹Qᵀ = 0.
template <class Scalar>
struct CotangentOfFrames {
  Vector<Scalar> lambda;

  Matrix<Scalar> tangent(const Matrix<Scalar>& x, const Matrix<Scalar>& G) const {
    const Eigen::Index n = x.rows() / 2;
    const Matrix<Scalar> weighted = x * lambda.cwiseInverse().asDiagonal();
    const auto Q = x.topRows(n), Q_bar = weighted.topRows(n), S_bar = weighted.bottomRows(n);
    const Matrix<Scalar> A = tangent_to_frames<Scalar>(Q, G.topRows(n));
    const Matrix<Scalar> R = G.bottomRows(n) * Q_bar.transpose() + A * S_bar.transpose();
    Matrix<Scalar> Y = R + R.transpose();
    SymmetricLyapunov<Scalar> lyapunov(n);
    lyapunov.factor(Q_bar * Q.transpose());
    lyapunov.solve(Y, Y);
    return stacked_pair<Scalar>(A, G.bottomRows(n) - Y * Q);
  }
  Scalar form(const Matrix<Scalar>&, const Matrix<Scalar>& u, const Matrix<Scalar>& v) const {
    return omega_pairs(u, v);
  }
};

}  // namespace stiefel
