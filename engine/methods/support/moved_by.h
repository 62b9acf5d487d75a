#pragma once

#include <string_view>

#include "engine/linalg/lie/multiplication.h"
#include "engine/methods/support/concepts.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

/// Base class of the forms of the rigid body in which SO(N) multiplies all blocks by the same
/// rotation: ẋ = x·Ω(x). `Derived` offers generator(x, Ω); `Action` is RightMultiplication or
/// LeftMultiplication.
template <class Derived, class Action>
class MovedBy {
 public:
  using State = typename Action::State;
  using Algebra = typename Action::Algebra;
  using Scalar = typename State::Scalar;

  /// Whether an invariant is constant along the orbits of the group. Functions of PQᵀ (or BQᵀ) and
  /// of QQᵀ are constant; both are quadratic in the state.
  static constexpr bool conserved_on_orbits(std::string_view invariant) {
    return invariant == family::spatial_momentum || invariant == family::casimirs ||
           invariant == family::orthogonality || invariant == family::PQt;
  }
  static constexpr bool quadratic(std::string_view invariant) {
    return conserved_on_orbits(invariant);
  }

  const Vector<Scalar>& lambda() const { return lambda_; }

  void field(const State& x, State& dx) {
    static_cast<Derived&>(*this).generator(x, Omega_);
    action_.velocity(x, Omega_, dx);
  }
  Algebra zero() const { return action_.zero(); }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const { action_.bracket(a, b, c); }
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    action_.displacement(x, Theta, dx);
  }

 protected:
  explicit MovedBy(Vector<Scalar> lambda)
      : lambda_(std::move(lambda)), action_(lambda_.size()), Omega_(action_.zero()) {}

  Vector<Scalar> lambda_;

 private:
  Action action_;
  Algebra Omega_;
};

}  // namespace stiefel
