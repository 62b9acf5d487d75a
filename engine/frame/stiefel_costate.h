#pragma once

#include "engine/dense/frame_projection.h"
#include "engine/dense/optimal_control.h"
#include "engine/methods/concepts.h"

namespace stiefel {

/// Geodesics on V(n, N) as the optimal control problem of [ST] Theorem 4, (68)–(69):
///
///     Q̇ = QU,   Ṗ = PU − QA,   A = [QᵀQ, UΛU],
///
/// where U is the OptimalControl of (Q, P), for any costate P (n × N). A state is Q over P, 2n × N,
/// every λ_i > 0. The motion keeps PQᵀ, hence k = PQᵀ + QPᵀ and m = PQᵀ − QPᵀ; QQᵀ = I; and the
/// energy ½ tr(SΛ⁻¹Sᵀ), S = QUΛ. The case k = 0 is the generalised McLachlan–Scovel system. O(Nn² +
/// n³) operations. At n = 1, [ST] (9), (13), (14):
///
///     q̇ = −Uq,   ṗ = −Up + Aq,   U = Λ⁻¹(qpᵀ − pqᵀ)Λ⁻¹ / (qᵀΛ⁻¹q),
///     Aq = (Δ/(qᵀΛ⁻¹q)²) ((qᵀΛ⁻¹q) q − Λ⁻¹q),   Δ = (pᵀΛ⁻¹q)² − (pᵀΛ⁻¹p)(qᵀΛ⁻¹q).
template <class Scalar_>
class StiefelCostate {
 public:
  static constexpr const char* name = "stiefel_costate";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;

  StiefelCostate(Vector<Scalar> lambda, Eigen::Index n)
      : lambda_(std::move(lambda)), n_(n), U_(lambda_, n), onto_frames_(n) {}

  const Vector<Scalar>& lambda() const { return lambda_; }
  Eigen::Index n() const { return n_; }

  /// Uses QA = SU + (SΛ⁻¹Sᵀ)Q, which holds because QQᵀ = I and UQᵀ = −Q̇ᵀ.
  void field(const State& x, State& dx) {
    if (n_ == 1) return field_of_point(x, dx);
    const auto Q = x.topRows(n_), P = x.bottomRows(n_);
    U_.set(Q, P);
    U_.apply(Q, dx.topRows(n_));
    U_.apply(P, dx.bottomRows(n_));
    S_ = dx.topRows(n_) * lambda_.asDiagonal();
    SQdot_.noalias() = S_ * dx.topRows(n_).transpose();
    U_.apply(S_, SU_);
    dx.bottomRows(n_) -= SU_;
    dx.bottomRows(n_).noalias() -= SQdot_ * Q;
  }

  /// Moves Q onto the frames, with P so that QᵀP − PᵀQ stays.
  void project(State& x) { onto_frames_(x); }

 private:
  void field_of_point(const State& x, State& dx) const {
    Scalar qq = 0, qp = 0, pp = 0;  // qᵀΛ⁻¹q, qᵀΛ⁻¹p, pᵀΛ⁻¹p
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      const Scalar q = x(0, j), p = x(1, j);
      qq += q * q / lambda_(j);
      qp += q * p / lambda_(j);
      pp += p * p / lambda_(j);
    }
    const Scalar a = (qp * qp - pp * qq) / (qq * qq);
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      const Scalar q = x(0, j), p = x(1, j);
      dx(0, j) = (p * qq - q * qp) / (lambda_(j) * qq);
      dx(1, j) = (p * qp - q * pp) / (lambda_(j) * qq) + a * (qq * q - q / lambda_(j));
    }
  }

  Vector<Scalar> lambda_;
  Eigen::Index n_;
  OptimalControl<Scalar> U_;
  Matrix<Scalar> S_{n_, lambda_.size()}, SU_{S_}, SQdot_{n_, n_};
  FrameProjection<Scalar> onto_frames_;
};

}  // namespace stiefel
