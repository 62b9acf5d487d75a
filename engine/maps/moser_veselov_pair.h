#pragma once

#include "engine/linalg/j_n.h"
#include "engine/maps/discrete_inverse.h"

namespace stiefel {

/// Moser and Veselov's algorithm 1, [RB] (4.4), for two frames the time h apart:
///
///     U_{k−1} = Q_{k−1}ᵀQ_k,   hM_k = U_{k−1}ᵀ J_D(U_{k−1}) U_{k−1} = ΛU_{k−1} − U_{k−1}ᵀΛ,
///     U_k = J_D⁻¹(hM_k),   Q_{k+1} = Q_k U_k.
///
/// h is a unit of time and nothing else: the frames decide. It is the Moser–Veselov map of
/// (Q_k, M_k); m = Q_{k−1} J_D(U_{k−1}) Q_{k−1}ᵀ / h is kept. U_{k−1} − I is formed from the
/// difference of the frames, so that M does not lose what h is small by (in compensated
/// arithmetic; in plain arithmetic it has an error of rounding/h).
/// State: Q_{k−1} over Q_k, 2N × N.
template <class Scalar_, Arithmetic arithmetic>
class MoserVeselovPair {
 public:
  using Scalar = Scalar_;
  using Point = Matrix<Scalar>;
  using State = typename DiscreteInverse<Scalar, arithmetic>::State;

  MoserVeselovPair(const Vector<Scalar>& lambda, Scalar h)
      : h_(h),
        N_(lambda.size()),
        lambda_(lambda),
        inverse_(lambda, h),
        difference_(N_, N_),
        E_(N_, N_) {}

  State start(const Point& x) const { return inverse_.start(x); }

  Ending step(State& state) {
    form_momentum(state);
    const Ending ending = inverse_.solve(state.memory);
    if (!ending.reached()) return ending;
    difference_.noalias() = state.x.value.bottomRows(N_) * inverse_.U_minus_I();
    shift(state.x.value);
    if constexpr (arithmetic == Arithmetic::compensated) shift(state.x.carry);
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i < N_; ++i) state.x.add_scalar(N_ + i, j, difference_(i, j));
    return {};
  }

  std::optional<double> largest_step(const State& state, double limit) {
    form_momentum(state);
    return inverse_.largest_step(limit);
  }

 private:
  /// M = (ΛE − EᵀΛ)/h with E = U_{k−1} − I = Q_{k−1}ᵀ(Q_k − Q_{k−1}).
  void form_momentum(const State& state) {
    difference_ = state.x.value.bottomRows(N_) - state.x.value.topRows(N_);
    if constexpr (arithmetic == Arithmetic::compensated)
      difference_ += state.x.carry.bottomRows(N_) - state.x.carry.topRows(N_);
    E_.noalias() = state.x.value.topRows(N_).transpose() * difference_;
    inverse_.M() = lambda_.asDiagonal() * E_ / h_;
    take_twice_skew_part(inverse_.M());
  }

  void shift(Point& x) const { x.topRows(N_) = x.bottomRows(N_); }

  Scalar h_;
  Eigen::Index N_;
  Vector<Scalar> lambda_;
  DiscreteInverse<Scalar, arithmetic> inverse_;
  Matrix<Scalar> difference_, E_;
};

}  // namespace stiefel
