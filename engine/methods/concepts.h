#pragma once

#include <concepts>
#include <optional>
#include <span>

#include "engine/numbers/scalar.h"
#include "stiefel/run_status.h"

namespace stiefel {

/// A continuous system ẋ = X(x). `State` is any dense Eigen type, and `field(x, dx)` is the vector
/// field X.
template <class S>
concept System = requires(S& system, const typename S::State& x, typename S::State& dx) {
  typename S::Scalar;
  { S::name } -> std::convertible_to<const char*>;
  system.field(x, dx);
};

/// A system that moves along the orbits of a group acting from the right, ẋ = x·ξ(x). `generator`
/// computes ξ, `bracket` the bracket of the algebra, and `displacement` x·exp(θ) − x. A Lie-group
/// method needs no more.
template <class S>
concept LieSystem = System<S> &&
    requires(S& system, const typename S::State& x, typename S::State& dx,
             const typename S::Algebra& a, typename S::Algebra& b) {
  { system.zero() } -> std::convertible_to<typename S::Algebra>;
  system.generator(x, b);
  system.bracket(a, a, b);
  system.displacement(x, a, dx);
};

/// One step of size h. The state holds everything that the next step depends on, including solver
/// history and carried rounding errors; `x.value` is the system's state, and `each` visits every
/// block of numbers. A step that does not end with `reached` leaves the state unchanged. So does a
/// step that is stopped inside (stiefel/stop.h), if the map has a `stops_before_change()` that
/// returns true; otherwise what is left then is undefined.
template <class F>
concept Map = requires(F map, typename F::State& state, const typename F::Point& start) {
  { map.step(state) } -> std::same_as<RunStatus>;
  { map.start(start) } -> std::same_as<typename F::State>;
  { map.largest_step(state, 1.0) } -> std::same_as<std::optional<double>>;
  state.x.value;
  state.each([](auto&) {});
};

/// A map whose `at` computes the state k steps after the start directly, for every k, and the state
/// at the first of several times.
template <class F>
concept DirectMap = Map<F> && requires(F map, typename F::State& state) {
  { map.at(state, Extended<typename F::Point::Scalar>(1)) } -> std::same_as<Outcome>;
  map.at(state, std::span<const typename F::Point::Scalar>());
};

}  // namespace stiefel
