#pragma once

#include "engine/dense/decompositions.h"

namespace stiefel {

/// The optimal control U ∈ so(N) of [ST] Theorem 2, 𝒵, from a frame Q and any costate P (n × N),
/// such as S or P_0, with QᵀP − PᵀQ = M; Q̇ = QU. U solves J_Q(U) = QᵀQUΛ + ΛUQᵀQ = M, and is unique
/// up to V with QV = 0; with K = QΛ⁻¹Qᵀ and every λ_i > 0,
///
///     U = Λ⁻¹(QᵀK⁻¹P − PᵀK⁻¹Q + QᵀXQ)Λ⁻¹,   KX + XK = (QΛ⁻¹Pᵀ)K⁻¹ − K⁻¹(PΛ⁻¹Qᵀ).
///
/// X is skew, so U = Λ⁻¹(QᵀL − LᵀQ)Λ⁻¹ with L = K⁻¹P + ½XQ. U has rank 2n at most; it is never
/// formed, only applied to n × N factors in O(Nn²). Does not allocate after construction.
template <class Scalar>
class OptimalControl {
 public:
  OptimalControl(const Vector<Scalar>& lambda, Eigen::Index n)
      : inverse_(lambda.cwiseInverse()),
        lyapunov_(n),
        L_(n, n),
        Q_bar_(n, lambda.size()),
        L_bar_(Q_bar_),
        K_(n, n),
        X_(n, n) {}

  template <class Frame, class Costate>
  void set(const Eigen::MatrixBase<Frame>& Q, const Eigen::MatrixBase<Costate>& P) {
    Q_bar_ = Q * inverse_.asDiagonal();
    K_.noalias() = Q_bar_ * Q.transpose();
    L_ = K_;
    factor_positive(L_);
    lyapunov_.factor(K_);
    K_.noalias() = P * Q_bar_.transpose();
    solve_positive(L_, K_);
    X_ = K_.transpose() - K_;
    lyapunov_.solve(X_, X_);

    L_bar_ = P;
    solve_positive(L_, L_bar_);
    L_bar_.noalias() += Scalar(0.5) * X_ * Q;
    L_bar_ = L_bar_ * inverse_.asDiagonal();
  }

  /// Sets FU = (FΛ⁻¹Qᵀ)LΛ⁻¹ − (FΛ⁻¹Lᵀ)QΛ⁻¹. `FU` and F must be different matrices.
  template <class Factor, class Product>
  void apply(const Eigen::MatrixBase<Factor>& F, Product&& FU) {
    K_.noalias() = F * Q_bar_.transpose();
    X_.noalias() = F * L_bar_.transpose();
    FU.noalias() = K_ * L_bar_;
    FU.noalias() -= X_ * Q_bar_;
  }

  /// Returns U as an N × N matrix; only for output.
  Matrix<Scalar> dense() const {
    const Matrix<Scalar> half = Q_bar_.transpose() * L_bar_;
    return half - half.transpose();
  }

 private:
  Vector<Scalar> inverse_;
  SymmetricLyapunov<Scalar> lyapunov_;
  /// L_ has the factor of K, Q_bar_ = QΛ⁻¹, L_bar_ = LΛ⁻¹; K_ and X_ are scratch space
  Matrix<Scalar> L_, Q_bar_, L_bar_, K_, X_;
};

}  // namespace stiefel
