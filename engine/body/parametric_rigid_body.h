#pragma once

#include <optional>
#include <string_view>

#include "engine/body/discrete_blocks.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/methods/concepts.h"
#include "stiefel/conservation.h"
#include "stiefel/invariant_names.h"
#include "stiefel/stop.h"

namespace stiefel {

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
template <class Scalar_>
class ParametricRigidBody {
 public:
  static constexpr const char* name = "parametric_rigid_body";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

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
      : lambda_(std::move(lambda)),
        mu_(mu),
        epsilon_(epsilon),
        exponential_(lambda_.size(), MatrixKind::general),
        lu_(lambda_.size()),
        xi_(zero()),
        M_(xi_),
        D_(xi_) {}

  const Vector<Scalar>& lambda() const { return lambda_; }
  Scalar mu() const { return mu_; }
  Scalar epsilon() const { return epsilon_; }

  void field(const State& x, State& dx) {
    generator(x, xi_);
    dx.noalias() = x * xi_;
  }

  Algebra zero() const { return Algebra::Zero(lambda_.size(), lambda_.size()); }

  /// Sets ξ = Ω + μΛ. Uses only the skew part of M_μ; its symmetric part is μΛ².
  void generator(const State& x, Algebra& xi) {
    const Eigen::Index N = lambda_.size();
    stop_point();
    xi = x.topRows(N);
    D_ = x.bottomRows(N);
    lu_.factor(xi);
    lu_.solve(D_, M_);
    stop_point();
    lu_.factor(D_);
    lu_.solve(xi, D_);
    M_ -= D_;
    M_ /= 2;  // halves M here, because 2ε may overflow
    inverse_inertia(lambda_, M_, epsilon_, xi);
    xi.diagonal() = mu_ * lambda_;
  }

  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const {
    c.noalias() = a * b;
    c.noalias() -= b * a;
  }
  void displacement(const State& x, const Algebra& theta, State& dx) {
    exponential_(theta, D_);
    dx.noalias() = x * D_;
  }

 private:
  Vector<Scalar> lambda_;
  Scalar mu_, epsilon_;
  Exponential<Scalar> exponential_;
  Lu<Scalar> lu_;
  Algebra xi_, M_, D_;
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
        lu_(N_) {}

  RunStatus step(State& state) {
    if (!(state.x.value * largest_growth_).allFinite()) return {Outcome::not_finite, std::nullopt};
    return DiscreteBlocks::step(state);
  }

  /// Computes M, half of it, before its skew part is taken, from M^μ/h; μΛ² is symmetric.
  void form_momentum(const Point& x, Point& M) {
    top_ = x.topRows(N_);
    bottom_ = x.bottomRows(N_);
    lu_.factor(top_);
    lu_.solve(bottom_, M);
    lu_.factor(bottom_);
    lu_.solve(top_, bottom_);
    M -= bottom_;
    M /= 2;  // halves M here, because 2ε may overflow
    M /= epsilon_;
  }

  Eigen::VectorXd growth;

 private:
  double epsilon_;
  double largest_growth_;  ///< bounds the factor by which a step can multiply an element
  Lu<double> lu_;
  Point top_, bottom_;
};

}  // namespace stiefel
