#pragma once

#include "engine/methods/support/concepts.h"
#include "engine/numbers/compensated.h"

namespace stiefel {

/// Uses a map of a left-invariant system as the map of the right-invariant one: transposes every N
/// × N block of a state ([RB] Prop. 2.1, 3.4: Q_r = Qᵀ, M_r = −M = Mᵀ, P_r = Pᵀ). Both systems have
/// the same numbers to the last bit. The states of `Inner` are stacked N × N blocks.
template <class Inner>
class Transposed {
 public:
  using Scalar = typename Inner::Scalar;
  using Point = typename Inner::Point;

  struct State {
    Accumulator<Point> x;
    typename Inner::State left;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
      left.each(visit);
    }
  };

  Transposed(Inner inner, Arithmetic arithmetic)
      : inner_(std::move(inner)), arithmetic_(arithmetic) {}

  State start(const Point& x) {
    Point left = x;
    transpose(x, left);
    return {Accumulator<Point>(x, arithmetic_), inner_.start(left)};
  }

  RunStatus step(State& state) {
    const RunStatus status = inner_.step(state.left);
    if (!status.reached()) return status;
    transpose(state.left.x.value, state.x.value);
    if (state.x.compensated) transpose(state.left.x.carry, state.x.carry);
    return {};
  }

  std::optional<double> largest_step(const State& state, double limit) {
    return inner_.largest_step(state.left, limit);
  }

 private:
  static void transpose(const Point& from, Point& to) {
    const Eigen::Index N = from.cols();
    for (Eigen::Index top = 0; top < from.rows(); top += N)
      to.middleRows(top, N) = from.middleRows(top, N).transpose();
  }

  Inner inner_;
  Arithmetic arithmetic_;
};

}  // namespace stiefel
