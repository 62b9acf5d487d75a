#pragma once

#include "engine/dense/decompositions.h"
#include "engine/dense/so_n.h"
#include "engine/dense/symmetric_lyapunov.h"

namespace stiefel {

/// 𝒵, [ST] Theorem 2: the U ∈ so(N) with J_Q(U) = QᵀQUΛ + ΛUQᵀQ = M, from Q and any P (or S, or
/// P_0) with QᵀP − PᵀQ = M; Q̇ = QU. With K = QΛ⁻¹Qᵀ, G = K⁻¹,
///
///     KX + XK = (QΛ⁻¹Pᵀ)G − G(PΛ⁻¹Qᵀ),   Y = GP + ½XQ,   U = Λ⁻¹(QᵀY − YᵀQ)Λ⁻¹,
///
/// stored as the factors Q and Y, n × N. (U is unique up to V with QV = 0; this one has rank ≤ 2n.)
/// For P = S, X = GQΛ⁻¹SᵀG (Lemma 4). Needs every λ_i > 0. O(Nn² + n³).
template <class Scalar>
class AngularVelocity {
 public:
  AngularVelocity(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q, const Matrix<Scalar>& P);

  const Matrix<Scalar>& X() const { return X_; }
  const Matrix<Scalar>& Y() const { return Y_; }

  /// Returns the product VU for V with N columns.
  Matrix<Scalar> left_times(const Matrix<Scalar>& V) const;

  Matrix<Scalar> Qdot() const;

  /// Returns U as an N × N matrix; only for output.
  Matrix<Scalar> dense() const;

 private:
  Vector<Scalar> inverse_;
  Matrix<Scalar> Q_, X_, Y_;
};

template <class Scalar>
AngularVelocity<Scalar>::AngularVelocity(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                                         const Matrix<Scalar>& P)
    : inverse_(lambda.cwiseInverse()), Q_(Q), X_(Q.rows(), Q.rows()) {
  const Matrix<Scalar> weighted = Q * inverse_.asDiagonal(), K = weighted * Q.transpose();
  Matrix<Scalar> L = K, GP = P;
  factor_positive(L);
  solve_positive(L, GP);
  const Matrix<Scalar> C = weighted * GP.transpose();  // QΛ⁻¹PᵀG
  SymmetricLyapunov<Scalar> lyapunov(Q.rows());
  lyapunov.factor(K);
  lyapunov.solve(C - C.transpose(), X_);
  Y_ = GP + X_ * Q / 2;
}

template <class Scalar>
Matrix<Scalar> AngularVelocity<Scalar>::left_times(const Matrix<Scalar>& V) const {
  const Matrix<Scalar> W = V * inverse_.asDiagonal();
  return ((W * Q_.transpose()) * Y_ - (W * Y_.transpose()) * Q_) * inverse_.asDiagonal();
}

template <class Scalar>
Matrix<Scalar> AngularVelocity<Scalar>::Qdot() const {
  return left_times(Q_);
}

template <class Scalar>
Matrix<Scalar> AngularVelocity<Scalar>::dense() const {
  const Matrix<Scalar> R = inverse_.asDiagonal() * (Q_.transpose() * Y_) * inverse_.asDiagonal();
  return R - R.transpose();
}

// Compiled once, in angular_velocity.cc.
extern template class AngularVelocity<double>;
extern template class AngularVelocity<long double>;
extern template class AngularVelocity<Quad>;

/// Returns the Q̇ of (Q, M), rigid body, n = N: Q̇ = QΩ, M = J(Ω) = ΛΩ + ΩΛ; [RB] §2. Needs λ_i + λ_j
/// > 0 for i ≠ j. All matrices are N × N.
template <class Scalar>
Matrix<Scalar> Qdot_of_M(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                         const Matrix<Scalar>& M) {
  Matrix<Scalar> Omega(M.rows(), M.cols());
  SoN<Scalar>::inverse_inertia(lambda, M, Omega);
  return Q * Omega;
}

}  // namespace stiefel
