#pragma once

#include "engine/dense/decompositions.h"
#include "engine/dense/frame_projection.h"
#include "engine/methods/concepts.h"

namespace stiefel {

/// Geodesics on the Stiefel manifold V(n, N) of frames QQᵀ = I_n with the energy ½ tr(ΛQ̇ᵀQ̇), 1 ≤ n
/// ≤ N, in variational form; [ST] (37)–(39):
///
///     Q̇ = SΛ⁻¹,   Ṡ = BQ,   KB + BK = −2Q̇Q̇ᵀ,   K = QΛ⁻¹Qᵀ.
///
/// Q and S = Q̇Λ are n × N, B and K are n × n; every λ_i > 0. (Erratum: the paper also prints S =
/// Q̇Λ⁻¹.) A state is Q over S, 2n × N, with QS̄ᵀ + S̄Qᵀ = 0 for S̄ = SΛ⁻¹. The motion keeps the
/// energy ½ tr(SΛ⁻¹Sᵀ), m = SQᵀ − QSᵀ, and QQᵀ = I. O(Nn² + n³) operations.
/// At n = 1, x̄ = Λ^{1/2}q moves on a geodesic of the ellipsoid x̄ᵀΛ⁻¹x̄ = 1, [ST] (16):
///
///     q̈ = −(q̇ᵀq̇ / qᵀΛ⁻¹q) Λ⁻¹q.
template <class Scalar_>
class Stiefel {
 public:
  static constexpr const char* name = "stiefel";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;

  Stiefel(Vector<Scalar> lambda, Eigen::Index n)
      : lambda_(std::move(lambda)), n_(n), lyapunov_(n), onto_frames_(n) {}

  const Vector<Scalar>& lambda() const { return lambda_; }
  Eigen::Index n() const { return n_; }

  void field(const State& x, State& dx) {
    if (n_ == 1) return field_of_point(x, dx);
    const auto Q = x.topRows(n_), S = x.bottomRows(n_);
    auto Qdot = dx.topRows(n_), Sdot = dx.bottomRows(n_);
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      Qdot.col(j) = S.col(j) / lambda_(j);
      Sdot.col(j) = Q.col(j) / lambda_(j);
    }
    K_.noalias() = Sdot * Q.transpose();
    B_.noalias() = Scalar(-2) * Qdot * Qdot.transpose();
    lyapunov_.factor(K_);
    lyapunov_.solve(B_, B_);
    Sdot.noalias() = B_ * Q;
  }

  /// Moves Q onto the frames, and S onto its constraint: S ← S − YQ with KY + YK = QS̄ᵀ + S̄Qᵀ.
  void project(State& x) {
    onto_frames_(x);
    const auto Q = x.topRows(n_);
    auto S = x.bottomRows(n_);
    K_.setZero();
    B_.setZero();
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      K_.noalias() += (1 / lambda_(j)) * Q.col(j) * Q.col(j).transpose();
      B_.noalias() += (1 / lambda_(j)) * Q.col(j) * S.col(j).transpose();
    }
    Y_ = B_ + B_.transpose();
    lyapunov_.factor(K_);
    lyapunov_.solve(Y_, Y_);
    for (Eigen::Index j = 0; j < x.cols(); ++j) S.col(j).noalias() -= Y_ * Q.col(j);
  }

 private:
  void field_of_point(const State& x, State& dx) const {
    Scalar speed2 = 0, K = 0;
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      dx(0, j) = x(1, j) / lambda_(j);
      speed2 += dx(0, j) * dx(0, j);
      K += x(0, j) * x(0, j) / lambda_(j);
    }
    for (Eigen::Index j = 0; j < x.cols(); ++j) dx(1, j) = -speed2 / K * x(0, j);
  }

  Vector<Scalar> lambda_;
  Eigen::Index n_;
  SymmetricLyapunov<Scalar> lyapunov_;
  FrameProjection<Scalar> onto_frames_;
  Matrix<Scalar> K_{n_, n_}, B_{K_}, Y_{K_};
};

}  // namespace stiefel
