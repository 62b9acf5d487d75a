#pragma once

#include <string_view>

#include "engine/linalg/j_n.h"
#include "engine/linalg/multiplication.h"
#include "engine/systems/concepts.h"

namespace stiefel {

/// The symmetric representation of the rigid body, right-invariant: [RB] (RightSRBn), with ε as in
/// RightSymmetricRigidBody,
///
///     Q̇_r = Ω_r Q_r,   Ṗ_r = Ω_r P_r,   Ω_r = J⁻¹(M_r),   M_r = (P_rQ_rᵀ − Q_rP_rᵀ)/ε.
///
/// Q_r = Qᵀ, P_r = Pᵀ of the left-invariant one (Prop. 3.4). It keeps Q_rᵀP_r, hence
/// m_r = Q_rᵀM_rQ_r, and the energy.
/// State: Q_r over P_r, 2N × N. SO(N) acts from the left on both at once.
template <class Scalar_>
class RightSymmetricRigidBody {
 public:
  static constexpr const char* name = "right_symmetric_rigid_body";
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

  explicit RightSymmetricRigidBody(Vector<Scalar> lambda, Scalar epsilon = 1)
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
    G_.noalias() = x.bottomRows(N) * x.topRows(N).transpose();
    inverse_inertia(lambda_, G_, epsilon_, Omega);
  }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const { action_.bracket(a, b, c); }
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    action_.displacement(x, Theta, dx);
  }

 private:
  Vector<Scalar> lambda_;
  Scalar epsilon_;
  LeftMultiplication<Scalar> action_;
  Algebra Omega_, G_;
};

}  // namespace stiefel
