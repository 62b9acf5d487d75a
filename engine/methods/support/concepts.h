#pragma once

#include <concepts>

#include "engine/numbers/scalar.h"

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

}  // namespace stiefel
