#pragma once

#include "engine/moser_veselov/discrete_body_3.h"

namespace stiefel {

/// U = J_D⁻¹(hM), that is UΛ − ΛUᵀ = hM, in three dimensions, with the step that it makes: the
/// counterpart of JDInverseN.
template <class Scalar, bool frame, Arithmetic arithmetic>
class JDInverse3 {
 public:
  using Body = DiscreteBody3<Scalar, frame, arithmetic>;
  using Point = typename Body::Point;
  using State = typename Body::State;

  /// The equation's start needs no history.
  struct Memory {
    template <class Visitor>
    void each(Visitor&&) {}
  };

  JDInverse3(const Vector<Scalar>& lambda, Scalar h)
      : inertia_(PrincipalMoments3<Extended<Scalar>>(lambda), h) {}

  Memory memory() const { return {}; }

  bool solve(const State& x, const Memory&) { return body_.solve(x, inertia_); }
  /// The same for the step t·h, from the solution found last.
  bool continue_to(const State& x, double t) {
    return body_.continue_to(x, inertia_, static_cast<Scalar>(t));
  }
  /// Starts anew from t = 0.
  void restart() { body_.restart(); }

  /// Q ← QU, M ← UᵀMU.
  void transport(State& x, Memory&) const { body_.transport(x, inertia_); }

 private:
  DiscreteInertia3<Scalar> inertia_;
  Body body_;
};

}  // namespace stiefel
