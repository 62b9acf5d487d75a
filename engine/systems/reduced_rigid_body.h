#pragma once

#include <string_view>

#include "engine/linalg/j_n.h"
#include "engine/linalg/multiplication.h"
#include "engine/systems/concepts.h"

namespace stiefel {

/// The reduced symmetric representation [RB] (8.2),
///
///     Q̇ = QΩ,   Ω = J⁻¹(Qᵀ(A − Aᵀ)Q)/ε,
///
/// in which A = PQᵀ is a constant of the motion, and so of the system: it is given with it, and
/// P = AQ is reported, not moved. M = Qᵀ(A − Aᵀ)Q/ε. It keeps what the rigid body keeps, the
/// Manakov integrals as tr((A − Aᵀ + μQΛ²Qᵀ)^k), (8.3).
/// State: Q, N × N. SO(N) acts from the right.
template <class Scalar_>
class ReducedRigidBody {
 public:
  static constexpr const char* name = "reduced_rigid_body";
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

  ReducedRigidBody(Vector<Scalar> lambda, Matrix<Scalar> A, Scalar epsilon = 1)
      : lambda_(std::move(lambda)),
        A_(std::move(A)),
        epsilon_(epsilon),
        action_(lambda_.size()),
        Omega_(action_.zero()),
        G_(Omega_),
        product_(Omega_) {}

  const Vector<Scalar>& lambda() const { return lambda_; }
  const Matrix<Scalar>& A() const { return A_; }
  Scalar epsilon() const { return epsilon_; }
  Matrix<Scalar> P(const State& Q) const { return A_ * Q; }

  void field(const State& x, State& dx) {
    generator(x, Omega_);
    action_.velocity(x, Omega_, dx);
  }

  Algebra zero() const { return action_.zero(); }
  void generator(const State& x, Algebra& Omega) {
    product_.noalias() = A_ * x;
    G_.noalias() = x.transpose() * product_;
    inverse_inertia(lambda_, G_, epsilon_, Omega);
  }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const { action_.bracket(a, b, c); }
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    action_.displacement(x, Theta, dx);
  }

 private:
  Vector<Scalar> lambda_;
  Matrix<Scalar> A_;
  Scalar epsilon_;
  RightMultiplication<Scalar> action_;
  Algebra Omega_, G_, product_;
};

}  // namespace stiefel
