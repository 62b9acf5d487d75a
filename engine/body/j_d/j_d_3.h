#pragma once

#include "engine/body/j_d/discrete_body_3.h"
#include "engine/body/principal_branch.h"

namespace stiefel {

/// Solves UΛ − ΛUᵀ = hM for U = J_D⁻¹(hM) in three dimensions and applies the step, with the
/// interface of JDInverseN.
template <class Scalar, bool frame>
class JDInverse3 {
 public:
  using Body = DiscreteBody3<Scalar, frame>;
  using Point = typename Body::Point;
  using State = typename Body::State;
  using Memory = NoMemory;

  JDInverse3(const Vector<Scalar>& lambda, Scalar h, bool moves_frame = true)
      : inertia_(PrincipalMoments3<Extended<Scalar>>(lambda), h), body_(moves_frame) {}

  Memory memory(const auto&) const { return {}; }

  bool solve(const State& x, const Memory&) { return body_.solve(x, inertia_); }
  /// Finds U for the step t·h, starting from the solution found last.
  bool continue_to(const State& x, double t) {
    return body_.continue_to(x, inertia_, static_cast<Scalar>(t));
  }
  /// Forgets the last solution: the next `continue_to` starts from t = 0.
  void restart() { body_.restart(); }

  /// Sets Q ← QU, M ← UᵀMU.
  void transport(State& x, Memory&) const { body_.transport(x, inertia_); }

 private:
  DiscreteInertia3<Scalar> inertia_;
  Body body_;
};

}  // namespace stiefel
