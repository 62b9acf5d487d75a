#pragma once

#include <string_view>

#include "engine/linalg/j_n.h"
#include "engine/linalg/multiplication.h"
#include "engine/systems/concepts.h"

namespace stiefel {

/// The symmetric representation of the rigid body, left-invariant: [RB] (3.1) = (SRBn), with the
/// scaling of Prop. 3.13,
///
///     Q̇ = QΩ,   Ṗ = PΩ,   Ω = J⁻¹(M),   M = (QᵀP − PᵀQ)/ε.
///
/// On SO(N) × SO(N) it is the rigid body with ‖M‖_op ≤ 2/ε. It keeps PQᵀ, hence m = QMQᵀ =
/// (PQᵀ − QPᵀ)/ε, the energy and all that the rigid body keeps.
/// State: Q over P, 2N × N. SO(N) acts from the right on both at once.
template <class Scalar_>
class SymmetricRigidBody {
 public:
  static constexpr const char* name = "symmetric_rigid_body";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

  /// Whether an invariant is constant along the group's orbits.
  static constexpr bool kept_on_orbits(std::string_view invariant) {
    return invariant == "spatial_momentum" || invariant == "casimirs" ||
           invariant == "orthogonality" || invariant == "PQt";
  }
  /// Whether it is a quadratic function of the state, or of such that are kept.
  static constexpr bool quadratic(std::string_view invariant) {
    return invariant == "spatial_momentum" || invariant == "casimirs" ||
           invariant == "orthogonality" || invariant == "PQt";
  }

  explicit SymmetricRigidBody(Vector<Scalar> lambda, Scalar epsilon = 1)
      : lambda_(std::move(lambda)),
        epsilon_(epsilon),
        action_(lambda_.size()),
        Omega_(action_.zero()),
        G_(Omega_) {}

  const Vector<Scalar>& lambda() const { return lambda_; }
  Scalar epsilon() const { return epsilon_; }

  void field(const State& x, State& dx) {
    generator(x, Omega_);
    action_.velocity(x, Omega_, dx);
  }

  Algebra zero() const { return action_.zero(); }
  void generator(const State& x, Algebra& Omega) {
    const Eigen::Index N = lambda_.size();
    G_.noalias() = x.topRows(N).transpose() * x.bottomRows(N);
    inverse_inertia(lambda_, G_, epsilon_, Omega);
  }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const { action_.bracket(a, b, c); }
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    action_.displacement(x, Theta, dx);
  }

 private:
  Vector<Scalar> lambda_;
  Scalar epsilon_;
  RightMultiplication<Scalar> action_;
  Algebra Omega_, G_;
};

}  // namespace stiefel
