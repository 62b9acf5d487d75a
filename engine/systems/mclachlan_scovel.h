#pragma once

#include <string_view>

#include "engine/linalg/j_n.h"
#include "engine/linalg/multiplication.h"
#include "engine/systems/concepts.h"

namespace stiefel {

/// The McLachlan–Scovel equations [RB] (5.5),
///
///     Q̇ = QΩ,   Ḃ = BΩ,   Ω = J⁻¹(QᵀB),
///
/// on the invariant manifold where QᵀB is skew; there QᵀB = M and B = QM = P − QPᵀQ. Off it the
/// skew part of QᵀB is taken. It keeps BQᵀ, which is m, the energy and all that the rigid body
/// keeps. State: Q over B, 2N × N. SO(N) acts from the right on both at once.
template <class Scalar_>
class McLachlanScovel {
 public:
  static constexpr const char* name = "mclachlan_scovel";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

  /// Whether an invariant is constant along the group's orbits.
  static constexpr bool kept_on_orbits(std::string_view invariant) {
    return invariant == "spatial_momentum" || invariant == "casimirs" ||
           invariant == "orthogonality";
  }
  /// Whether it is a quadratic function of the state, or of such that are kept.
  static constexpr bool quadratic(std::string_view invariant) {
    return invariant == "spatial_momentum" || invariant == "casimirs" ||
           invariant == "orthogonality";
  }

  explicit McLachlanScovel(Vector<Scalar> lambda)
      : lambda_(std::move(lambda)), action_(lambda_.size()), Omega_(action_.zero()), G_(Omega_) {}

  const Vector<Scalar>& lambda() const { return lambda_; }

  void field(const State& x, State& dx) {
    generator(x, Omega_);
    action_.velocity(x, Omega_, dx);
  }

  Algebra zero() const { return action_.zero(); }
  void generator(const State& x, Algebra& Omega) {
    const Eigen::Index N = lambda_.size();
    G_.noalias() = x.topRows(N).transpose() * x.bottomRows(N);
    inverse_inertia(lambda_, G_, Scalar(2), Omega);
  }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const { action_.bracket(a, b, c); }
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    action_.displacement(x, Theta, dx);
  }

 private:
  Vector<Scalar> lambda_;
  RightMultiplication<Scalar> action_;
  Algebra Omega_, G_;
};

}  // namespace stiefel
