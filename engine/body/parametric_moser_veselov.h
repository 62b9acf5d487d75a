#pragma once

#include "engine/body/discrete_blocks.h"
#include "engine/dense/decompositions.h"

namespace stiefel {

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
