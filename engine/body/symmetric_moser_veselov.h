#pragma once

#include "engine/body/discrete_inverse.h"
#include "engine/dense/inertia_operator.h"

namespace stiefel {

/// The symmetric representation of the discrete rigid body, [RB] (4.7) = (SDRBn), for the step h,
/// with P scaled so that it belongs to εM (Prop. 3.13):
///
///     UΛ − ΛUᵀ = hM,   M = (QᵀP − PᵀQ)/ε,
///     Q_{k+1} = Q_k U,   P_{k+1} = P_k U.
///
/// ε = h gives the paper's own variables, in which h does not appear. On SO(N) × SO(N) it is the
/// Moser–Veselov map of (Q, M), and it keeps PQᵀ. Ends with left_domain where there is no U. State:
/// Q over P, 2N × N.
template <class Scalar_>
class SymmetricMoserVeselov {
 public:
  using Scalar = Scalar_;
  using Point = Matrix<Scalar>;
  using State = typename DiscreteInverse<Scalar>::State;

  SymmetricMoserVeselov(const Vector<Scalar>& lambda, Scalar h, Scalar epsilon,
                        Arithmetic arithmetic = Arithmetic::compensated)
      : N_(lambda.size()), epsilon_(epsilon), inverse_(lambda, h, arithmetic), moved_(2 * N_, N_) {}

  State start(const Point& x) const { return inverse_.start(x); }

  RunStatus step(State& state) {
    form_momentum(state.x.value);
    const RunStatus status = inverse_.solve(state.memory);
    if (!status.reached()) return status;
    moved_.noalias() = state.x.value * inverse_.U_minus_I();
    state.x.add(moved_);
    return {};
  }

  std::optional<double> largest_step(const State& state, double limit) {
    form_momentum(state.x.value);
    return inverse_.largest_step(limit);
  }

 private:
  void form_momentum(const Point& x) {
    inverse_.M().noalias() = x.topRows(N_).transpose() * x.bottomRows(N_);
    inverse_.M() /= epsilon_;
    subtract_transpose(inverse_.M());
  }

  Eigen::Index N_;
  Scalar epsilon_;
  DiscreteInverse<Scalar> inverse_;
  Matrix<Scalar> moved_;
};

}  // namespace stiefel
