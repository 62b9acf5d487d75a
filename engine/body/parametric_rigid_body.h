#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "engine/body/multiplied_blocks.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/methods/concepts.h"
#include "stiefel/conservation.h"
#include "stiefel/invariant_names.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Returns G = Q⁻¹P and G⁻¹.
template <class Scalar>
std::array<Matrix<Scalar>, 2> quotients(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return {Lu<Scalar>(Q).solve(P), Lu<Scalar>(P).solve(Q)};
}
/// Returns εM_μ = Q_μ⁻¹P_μ − P_μ⁻¹Q_μ, [RB] (8.5) and (8.10) with the scaling of Prop. 3.13. tr
/// (εM_μ)^k and every eigenvalue of εM_μ are constant.
template <class Scalar>
Matrix<Scalar> parametric_momentum(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  const auto [G, inverse] = quotients(Q, P);
  return G - inverse;
}
/// Computes half of it, because 2ε may overflow, from Q over P, allocating at first use only.
template <class Scalar>
class HalfParametricMomentum {
 public:
  explicit HalfParametricMomentum(Eigen::Index N) : lu_(N) {}

  void operator()(const Matrix<Scalar>& x, Matrix<Scalar>& M) {
    stop_point();
    Q_ = x.topRows(x.cols());
    P_ = x.bottomRows(x.cols());
    lu_.factor(Q_);
    lu_.solve(P_, M);
    stop_point();
    lu_.factor(P_);
    lu_.solve(Q_, P_);
    M -= P_;
    M /= 2;
  }

 private:
  Lu<Scalar> lu_;
  Matrix<Scalar> Q_, P_;
};

/// The symmetric representation with parameter μ, [RB] (8.4)–(8.6), in GL(N), with the scaling of
/// Prop. 3.13 (ε = 1 gives the paper's equations):
///
///     Q̇_μ = Q_μ(Ω + μΛ),   Ṗ_μ = P_μ(Ω + μΛ),
///     Ω = J⁻¹(M_μ − μΛ²),   M_μ = (Q_μ⁻¹P_μ − P_μ⁻¹Q_μ)/ε,
///
/// on the invariant manifold where M = M_μ − μΛ² is skew; there M moves as the momentum of the
/// rigid body. Off the manifold M is the skew part. The motion keeps εm_μ = P_μQ_μ⁻¹ − Q_μP_μ⁻¹,
/// P_μQ_μ⁻¹, and every invariant of M. State: Q_μ over P_μ, 2N × N, both invertible. GL(N) acts
/// from the right on both blocks.
template <class Scalar>
class ParametricRigidBody
    : public MultipliedBlocks<ParametricRigidBody<Scalar>, Scalar, MatrixKind::general> {
 public:
  using Base = MultipliedBlocks<ParametricRigidBody, Scalar, MatrixKind::general>;
  using typename Base::Algebra, typename Base::State;
  static constexpr const char* name = "parametric_rigid_body";

  /// Whether an invariant is constant along the orbits of the group.
  static constexpr bool conserved_on_orbits(std::string_view invariant) {
    return invariant == family::PQ_inverse;
  }

  /// What every method does to an invariant on this system, beyond what it declares for all
  /// systems. Every method multiplies Q and P by the same matrix, which keeps P = AQ.
  static constexpr std::optional<Conservation> conservation(std::string_view invariant) {
    if (invariant == family::PQ_inverse) return Conservation::exact;
    return std::nullopt;
  }
  /// Whether the error of an invariant has no trend under Runge–Kutta steps of a fixed size. These
  /// steps keep tr M_μᵏ, and the error of the Casimirs of M is proportional to μ.
  static constexpr bool without_trend(std::string_view invariant) {
    return invariant == family::casimirs;
  }

  ParametricRigidBody(Vector<Scalar> lambda, Scalar mu, Scalar epsilon = 1)
      : Base(std::move(lambda), epsilon), mu_(mu), half_momentum_(this->lambda_.size()) {}

  Scalar mu() const { return mu_; }

  /// Sets ξ = Ω + μΛ. Uses only the skew part of M_μ; its symmetric part is μΛ².
  void generator(const State& x, Algebra& xi) {
    half_momentum_(x, D_);
    inverse_inertia(lambda_, D_, epsilon_, xi);
    xi.diagonal() = mu_ * lambda_;
  }

 private:
  using Base::D_, Base::epsilon_, Base::lambda_;

  Scalar mu_;
  HalfParametricMomentum<Scalar> half_momentum_;
};

/// The symmetric representation of the discrete rigid body with parameter μ, [RB] (8.10), in GL(N),
/// with P scaled so that it belongs to ε/h times the paper's M^μ (Prop. 3.13; ε = h gives the
/// paper's P):
///
///     M^μ = (h/ε)((Q^μ)⁻¹P^μ − (P^μ)⁻¹Q^μ) = hM + μΛ²,   U = J_D⁻¹(M^μ − μΛ²),
///     Q^μ_{k+1} = Q^μ_k(U + μΛ),   P^μ_{k+1} = P^μ_k(U + μΛ),
///
/// J_D(U) = UΛ − ΛUᵀ (erratum: with the printed ΩᵀΛ − ΛΩ, M^μ − μΛ² does not stay skew). Then
/// M^μ_{k+1} = (U + μΛ)⁻¹M^μ_k(U + μΛ), (8.11), and M moves by the Moser–Veselov map, on the
/// invariant manifold where M is skew. Off the manifold M is the skew part. The map keeps
/// P^μ(Q^μ)⁻¹ − Q^μ(P^μ)⁻¹. Its limit as h → 0 is ParametricRigidBody with parameter μ/h. State:
/// Q^μ over P^μ, 2N × N, both invertible.
class ParametricMoserVeselov : public DiscreteBlocks<ParametricMoserVeselov> {
 public:
  ParametricMoserVeselov(const Eigen::VectorXd& lambda, double h, double mu)
      : ParametricMoserVeselov(lambda, h, mu, h) {}
  ParametricMoserVeselov(const Eigen::VectorXd& lambda, double h, double mu, double epsilon)
      : DiscreteBlocks(lambda, h, Arithmetic::compensated),
        growth(mu * lambda),
        epsilon_(epsilon),
        largest_growth_(static_cast<double>(N_) * (2 + growth.cwiseAbs().maxCoeff())),
        half_momentum_(N_) {}

  RunStatus step(State& state) {
    if (!(state.x.value * largest_growth_).allFinite()) return {Outcome::not_finite, std::nullopt};
    return DiscreteBlocks::step(state);
  }

  /// Computes M, half of it, before its skew part is taken, from M^μ/h; μΛ² is symmetric.
  void form_momentum(const Point& x, Point& M) {
    half_momentum_(x, M);
    M /= epsilon_;
  }

  Eigen::VectorXd growth;

 private:
  double epsilon_;
  double largest_growth_;  ///< bounds the factor by which a step can multiply an element
  HalfParametricMomentum<double> half_momentum_;
};

}  // namespace stiefel
