#pragma once

#include <concepts>

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// A continuous system ẋ = X(x): `State`, any dense Eigen type, and `field(x, dx)`, the vector
/// field X.
template <class S>
concept System = requires(S& system, const typename S::State& x, typename S::State& dx) {
  typename S::Scalar;
  { S::name } -> std::convertible_to<const char*>;
  system.field(x, dx);
};

/// A system that moves along the orbits of a group acting from the right, ẋ = x·ξ(x): its generator
/// ξ, the bracket of the algebra, and x·exp(θ) − x. That is all a Lie-group method needs.
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
