#pragma once

#include <optional>
#include <string_view>

#include "engine/methods/concepts.h"
#include "stiefel/conservation.h"

namespace stiefel {

/// What a system says of itself to a method, as values. A general method (methods/support/method.h)
/// decides by these whether it applies to a system, and what it does to an invariant, without being
/// compiled for that system. A null pointer means that the system says nothing.
struct SystemTraits {
  using Property = bool (*)(std::string_view invariant);

  bool lie_group = false;  ///< the system is a LieSystem
  bool projects = false;   ///< the system has `project`, onto the manifold of its states
  /// Whether the invariant is quadratic, or a function of quadratic invariants.
  Property quadratic = nullptr;
  /// Whether the invariant is constant on the orbits of the group. Every LieSystem declares it.
  Property conserved_on_orbits = nullptr;
  /// Whether the error of the invariant has no trend even by a method that keeps nothing.
  Property without_trend = nullptr;
  /// What every method does to the invariant; nullopt: the method decides.
  std::optional<Conservation> (*conservation)(std::string_view invariant) = nullptr;
};

/// The traits of the system S.
template <class S>
inline constexpr SystemTraits system_traits = [] {
  SystemTraits traits;
  traits.projects = requires(S & system, typename S::State & x) { system.project(x); };
  if constexpr (LieSystem<S>) {
    traits.lie_group = true;
    traits.conserved_on_orbits = [](std::string_view v) { return S::conserved_on_orbits(v); };
  }
  if constexpr (requires(std::string_view v) { S::quadratic(v); })
    traits.quadratic = [](std::string_view v) { return S::quadratic(v); };
  if constexpr (requires(std::string_view v) { S::without_trend(v); })
    traits.without_trend = [](std::string_view v) { return S::without_trend(v); };
  if constexpr (requires(std::string_view v) { S::conservation(v); })
    traits.conservation = [](std::string_view v) { return S::conservation(v); };
  return traits;
}();

}  // namespace stiefel
