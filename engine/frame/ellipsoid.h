#pragma once

#include "engine/dense/frame_projection.h"
#include "engine/methods/concepts.h"

namespace stiefel {

/// Geodesics on the sphere qᵀq = 1 with the energy ½ q̇ᵀΛq̇. With x̄ = Λ^{1/2}q they are the
/// geodesics on the ellipsoid x̄ᵀΛ⁻¹x̄ = 1. V(n, N) at n = 1, in Lagrangian form, [ST] (16):
///
///     q̈ = −(q̇ᵀq̇ / qᵀΛ⁻¹q) Λ⁻¹q.
///
/// A state is the row qᵀ over q̇ᵀ, 2 × N, with qᵀq̇ = 0; every λ_i > 0.
template <class Scalar_>
class Ellipsoid {
 public:
  static constexpr const char* name = "ellipsoid";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;

  explicit Ellipsoid(Vector<Scalar> lambda) : lambda_(std::move(lambda)), onto_sphere_(1) {}

  const Vector<Scalar>& lambda() const { return lambda_; }

  void field(const State& x, State& dx) const {
    Scalar speed2 = 0, K = 0;
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      speed2 += x(1, j) * x(1, j);
      K += x(0, j) * x(0, j) / lambda_(j);
    }
    const Scalar b = -speed2 / K;
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      dx(0, j) = x(1, j);
      dx(1, j) = b * x(0, j) / lambda_(j);
    }
  }

  /// Moves q onto the sphere, and q̇ onto its tangent space: q̇ ← q̇ − (q·q̇ / qᵀΛ⁻¹q) Λ⁻¹q.
  void project(State& x) {
    onto_sphere_(x);
    Scalar along = 0, K = 0;
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      along += x(0, j) * x(1, j);
      K += x(0, j) * x(0, j) / lambda_(j);
    }
    for (Eigen::Index j = 0; j < x.cols(); ++j) x(1, j) -= along / K * x(0, j) / lambda_(j);
  }

 private:
  Vector<Scalar> lambda_;
  FrameProjection<Scalar> onto_sphere_;
};

/// Geodesics on the ellipsoid in the variables (q, p) with any costate p; [ST] (9), (13), (14):
///
///     q̇ = −Uq,   ṗ = −Up + Aq,   U = Λ⁻¹(qpᵀ − pqᵀ)Λ⁻¹ / (qᵀΛ⁻¹q),
///     Aq = (Δ/(qᵀΛ⁻¹q)²) ((qᵀΛ⁻¹q) q − Λ⁻¹q),   Δ = (pᵀΛ⁻¹q)² − (pᵀΛ⁻¹p)(qᵀΛ⁻¹q).
///
/// A state is the row qᵀ over pᵀ, 2 × N. The motion keeps qᵀp, qᵀq = 1, the energy, and the
/// coefficients of the Lax matrix (18).
template <class Scalar_>
class EllipsoidCostate {
 public:
  static constexpr const char* name = "ellipsoid";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;

  explicit EllipsoidCostate(Vector<Scalar> lambda) : lambda_(std::move(lambda)), onto_sphere_(1) {}

  const Vector<Scalar>& lambda() const { return lambda_; }

  void field(const State& x, State& dx) const {
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

  /// Moves q onto the sphere, with p so that qpᵀ − pqᵀ stays.
  void project(State& x) { onto_sphere_(x); }

 private:
  Vector<Scalar> lambda_;
  FrameProjection<Scalar> onto_sphere_;
};

}  // namespace stiefel
