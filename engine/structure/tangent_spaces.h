#pragma once

#include <utility>

#include "engine/dense/decompositions.h"
#include "engine/structure/forms.h"

namespace stiefel {

/// The symplectic manifolds on which the systems live. Each has `form(x, u, v)` and `tangent(x,
/// G)`, which returns a tangent vector at the state x from any matrix G of x's shape; this map is
/// linear in G and onto. A state is two n × N blocks, one above the other.

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

/// (Q, M) ∈ T*SO(N) with ω, [RB] (3.13).
template <class Scalar>
struct CotangentOfRotations {
  Matrix<Scalar> tangent(const Matrix<Scalar>& x, const Matrix<Scalar>& G) const {
    const Matrix<Scalar> Z = G.bottomRows(x.cols());
    return stacked_pair<Scalar>(tangent_to_frames<Scalar>(x.topRows(x.cols()), G.topRows(x.cols())),
                                (Z - Z.transpose()) / 2);
  }
  Scalar form(const Matrix<Scalar>& x, const Matrix<Scalar>& u, const Matrix<Scalar>& v) const {
    return omega_canonical(x, u, v);
  }
};

/// (Q, P) ∈ S ⊂ SO(N) × SO(N) with Ω_gl, [RB] (3.5).
template <class Scalar>
struct PairsOfRotations {
  Matrix<Scalar> tangent(const Matrix<Scalar>& x, const Matrix<Scalar>& G) const {
    return tangent_to_pairs(x, G);
  }
  Scalar form(const Matrix<Scalar>&, const Matrix<Scalar>& u, const Matrix<Scalar>& v) const {
    return Omega_gl(u, v);
  }
};

/// (Q_{k−1}, Q_k) ∈ E_L ⊂ SO(N) × SO(N) with Ω_L, [RB] (7.8).
template <class Scalar>
struct ConsecutiveRotations {
  Vector<Scalar> lambda;

  Matrix<Scalar> tangent(const Matrix<Scalar>& x, const Matrix<Scalar>& G) const {
    return tangent_to_pairs(x, G);
  }
  Scalar form(const Matrix<Scalar>&, const Matrix<Scalar>& u, const Matrix<Scalar>& v) const {
    return Omega_L(lambda, u, v);
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
