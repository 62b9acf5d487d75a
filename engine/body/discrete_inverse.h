#pragma once

#include "engine/body/j_d/j_d_n.h"
#include "engine/body/principal_branch.h"

namespace stiefel {

/// Computes U − I for maps whose state does not hold M: such a map computes M from its state at
/// every step and moves the state by U. `State` is the system's state with the solver's history.
template <class Scalar>
class DiscreteInverse {
 public:
  using JDInverse = JDInverseN<Scalar>;

  struct State {
    Accumulator<Matrix<Scalar>> x;
    typename JDInverse::Memory memory;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
      memory.each(visit);
    }
  };

  DiscreteInverse(const Vector<Scalar>& lambda, Scalar h,
                  Arithmetic arithmetic = Arithmetic::compensated)
      : arithmetic_(arithmetic),
        branch_(lambda, h),
        M_(Matrix<Scalar>::Zero(lambda.size(), lambda.size()), arithmetic) {}

  State start(const Matrix<Scalar>& x) const {
    return {Accumulator<Matrix<Scalar>>(x, arithmetic_), branch_.memory()};
  }

  /// Returns the M that `solve` and `largest_step` read; the map must write it before it calls
  /// them.
  Matrix<Scalar>& M() { return M_.value; }

  /// Finds U. On success adds the solution to the history; `U_minus_I` then belongs to this U.
  RunStatus solve(typename JDInverse::Memory& memory) {
    if (!M_.value.allFinite()) return {Outcome::not_finite, std::nullopt};
    if (M_.compensated) M_.carry.setZero();
    const RunStatus status = branch_.solve(M_, memory);
    if (status.reached()) branch_.inverse().transport(M_, memory);
    return status;
  }
  const Matrix<Scalar>& U_minus_I() { return branch_.inverse().U_minus_I(); }

  double largest_step(double limit) { return branch_.largest_step(M_, limit); }

 private:
  Arithmetic arithmetic_;
  PrincipalBranch<JDInverse> branch_;
  Accumulator<Matrix<Scalar>> M_;
};

}  // namespace stiefel
