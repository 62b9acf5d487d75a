#pragma once

#include <string_view>

#include "engine/dense/so_3.h"
#include "engine/dense/so_n.h"
#include "engine/methods/concepts.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

/// The free rigid body in N dimensions, left-invariant: [RB] (2.2), (2.3)
///
///     Q̇ = QΩ,   Ṁ = [M, Ω],   M = J(Ω) = ΛΩ + ΩΛ,
///
/// so Ω_ij = M_ij / (λ_i + λ_j), which needs only λ_i + λ_j > 0 for i ≠ j. The motion keeps the
/// energy ½ tr(ΛΩᵀΩ), the spatial momentum QMQᵀ, the eigenvalues of M, and every coefficient of
/// tr((M + μΛ²)^k), k = 2..N (Manakov; [RB] (2.4)).
///
/// `Space` is the form of (Q, M): matrices (SoN, every N), quaternion and vector (So3), or columns
/// and six numbers (So4). The state may be M alone.
template <class Space_>
class RigidBody {
 public:
  static constexpr const char* name = "rigid_body";
  using Space = Space_;
  using Scalar = typename Space::Scalar;
  using State = typename Space::State;
  using Algebra = typename Space::Algebra;
  using Lambda = typename Space::Lambda;

  /// Whether an invariant is constant along the orbits of the group.
  static constexpr bool conserved_on_orbits(std::string_view invariant) {
    return invariant == family::spatial_momentum || invariant == family::casimirs ||
           invariant == family::orthogonality;
  }

  /// `has_frame` says whether the states of the scene have a Q; states in coordinates hold zeros
  /// without it.
  explicit RigidBody(Lambda lambda, bool has_frame = true)
      : lambda_(std::move(lambda)),
        has_frame_(has_frame),
        inverse_inertia_(lambda_),
        space_(lambda_.size()),
        Omega_(space_.zero()) {}

  const Lambda& lambda() const { return lambda_; }
  bool has_frame() const { return has_frame_; }

  void field(const State& x, State& dx) {
    generator(x, Omega_);
    space_.velocity(lambda_, x, Omega_, dx);
  }

  Algebra zero() const { return space_.zero(); }
  void generator(const State& x, Algebra& Omega) const { inverse_inertia_(x, Omega); }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const { space_.bracket(a, b, c); }
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    space_.displacement(x, Theta, dx);
  }

 private:
  Lambda lambda_;
  bool has_frame_;
  typename Space::InverseInertia inverse_inertia_;
  Space space_;
  Algebra Omega_;
};

}  // namespace stiefel
