#pragma once

#include "engine/rigid_body/j_d/j_d_n.h"
#include "engine/rigid_body/moser_veselov/principal_branch.h"

namespace stiefel {

/// Moser and Veselov's algorithm 1, [RB] (4.4), for two frames separated by the time h:
///
///     U_{k−1} = Q_{k−1}ᵀQ_k,   hM_k = U_{k−1}ᵀ J_D(U_{k−1}) U_{k−1} = ΛU_{k−1} − U_{k−1}ᵀΛ,
///     U_k = J_D⁻¹(hM_k),   Q_{k+1} = Q_k U_k.
///
/// h is only a unit of time: the frames alone determine the motion. The map is the Moser–Veselov
/// map of (Q_k, M_k) and keeps m = Q_{k−1} J_D(U_{k−1}) Q_{k−1}ᵀ / h. M_k is computed once, at the
/// start, from the difference of the frames, which avoids cancellation for small h. It then moves
/// by M_{k+1} = U_kᵀM_kU_k. If it were computed from the frames at every step, it would accumulate
/// their rounding errors divided by h. State: Q_{k−1} over Q_k, 2N × N, and M_k.
template <class Scalar_>
class MoserVeselovPair {
 public:
  using Scalar = Scalar_;
  using Point = Matrix<Scalar>;
  using JDInverse = JDInverseN<Scalar>;

  struct State {
    Accumulator<Point> x, M;
    typename JDInverse::Memory memory;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
      M.each(visit);
      memory.each(visit);
    }
  };

  MoserVeselovPair(const Vector<Scalar>& lambda, Scalar h)
      : h_(h), N_(lambda.size()), lambda_(lambda), branch_(lambda, h), increment_(N_, N_) {}

  State start(const Point& x) const {
    const auto sum = [](const Point& start) {
      return Accumulator<Point>(start, Arithmetic::compensated);
    };
    return {sum(x), sum(momentum(x)), branch_.memory()};
  }

  RunStatus step(State& state) {
    if (!state.M.value.allFinite()) return {Outcome::not_finite, std::nullopt};
    const RunStatus status = branch_.solve(state.M, state.memory);
    if (!status.reached()) return status;
    branch_.inverse().transport(state.M, state.memory);
    increment_.noalias() = state.x.value.bottomRows(N_) * branch_.inverse().U_minus_I();
    shift(state.x.value);
    shift(state.x.carry);
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i < N_; ++i) state.x.add_scalar(N_ + i, j, increment_(i, j));
    return {};
  }

  std::optional<double> largest_step(const State& state, double limit) {
    return branch_.largest_step(state.M, limit);
  }

 private:
  /// Returns (ΛE − EᵀΛ)/h with E = U_{k−1} − I = Q_{k−1}ᵀ(Q_k − Q_{k−1}).
  Point momentum(const Point& x) const {
    const Point E = x.topRows(N_).transpose() * (x.bottomRows(N_) - x.topRows(N_));
    const Point product = lambda_.asDiagonal() * E;
    return (product - product.transpose()) / h_;
  }

  void shift(Point& x) const { x.topRows(N_) = x.bottomRows(N_); }

  Scalar h_;
  Eigen::Index N_;
  Vector<Scalar> lambda_;
  PrincipalBranch<JDInverse> branch_;
  Matrix<Scalar> increment_;
};

}  // namespace stiefel
