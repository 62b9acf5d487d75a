#pragma once

#include "engine/body/discrete_inverse.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"

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
template <class Scalar_>
class ParametricMoserVeselov {
 public:
  using Scalar = Scalar_;
  using Point = Matrix<Scalar>;
  using State = typename DiscreteInverse<Scalar>::State;

  ParametricMoserVeselov(const Vector<Scalar>& lambda, Scalar h, Scalar mu)
      : ParametricMoserVeselov(lambda, h, mu, h) {}
  ParametricMoserVeselov(const Vector<Scalar>& lambda, Scalar h, Scalar mu, Scalar epsilon)
      : epsilon_(epsilon),
        N_(lambda.size()),
        mu_lambda_(mu * lambda),
        growth_(static_cast<Scalar>(N_) * (2 + mu_lambda_.cwiseAbs().maxCoeff())),
        inverse_(lambda, h),
        lu_(N_),
        product_(N_, N_),
        moved_(2 * N_, N_) {}

  State start(const Point& x) const { return inverse_.start(x); }

  RunStatus step(State& state) {
    if (!(state.x.value * growth_).allFinite()) return {Outcome::not_finite, std::nullopt};
    form_momentum(state.x.value);
    const RunStatus status = inverse_.solve(state.memory);
    if (!status.reached()) return status;
    moved_.noalias() = state.x.value * inverse_.U_minus_I();
    moved_ += state.x.value * mu_lambda_.asDiagonal();
    state.x.add(moved_);
    return {};
  }

  std::optional<double> largest_step(const State& state, double limit) {
    form_momentum(state.x.value);
    return inverse_.largest_step(limit);
  }

 private:
  /// Computes M as the skew part of M^μ/h; μΛ² is symmetric.
  void form_momentum(const Point& x) {
    top_ = x.topRows(N_);
    product_ = x.bottomRows(N_);
    lu_.factor(top_);
    lu_.solve(product_, inverse_.M());
    lu_.factor(product_);
    lu_.solve(top_, product_);
    inverse_.M() -= product_;
    inverse_.M() /= 2;  // halves M here, because 2ε may overflow
    inverse_.M() /= epsilon_;
    subtract_transpose(inverse_.M());
  }

  Scalar epsilon_;
  Eigen::Index N_;
  Vector<Scalar> mu_lambda_;
  Scalar growth_;  ///< bounds the factor by which a step can multiply an element
  DiscreteInverse<Scalar> inverse_;
  Lu<Scalar> lu_;
  Matrix<Scalar> top_, product_, moved_;
};

}  // namespace stiefel
