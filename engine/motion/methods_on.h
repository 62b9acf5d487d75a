#pragma once

#include "engine/motion/method_entry.h"
#include "stiefel/catalogue.h"

namespace stiefel {

/// Returns the result of `conservation` for each invariant of a system.
template <class ConservationOf>
std::vector<Preservation> preservations(const SystemInfo& info, ConservationOf conservation) {
  std::vector<Preservation> all;
  for (const auto& invariant : info.invariants)
    all.push_back({invariant.name, conservation(invariant.name)});
  return all;
}

/// Returns the declarations of a discrete system that keeps all its invariants.
inline std::vector<MethodOnSystem> keeps_all(const SystemInfo& info) {
  return {{"", preservations(info, [](auto) { return Conservation::exact; })}};
}

/// Returns what Method, which applies to S, does to the invariants that `info` lists, and for which
/// Λ it has a map.
template <class Method, class S>
MethodOnSystem declared_by(const SystemInfo& info) {
  MethodOnSystem on{Method::traits.name, preservations(info, conservation_by<Method, S>)};
  if constexpr (requires { Method::template MotionOf<S>::where; }) {
    on.where = Method::template MotionOf<S>::where;
    on.takes = Method::template takes<S>;
  }
  return on;
}

/// Returns what a general method does to the invariants that `info` lists; nullopt if it does not
/// apply to the system.
std::optional<MethodOnSystem> declared_by(const MethodEntry& method, const SystemTraits& system,
                                          const SystemInfo& info);

/// Returns the methods that apply to S and what they do to the invariants that `info` lists, in the
/// order of the catalogue.
template <class S>
std::vector<MethodOnSystem> methods_on(const SystemInfo& info) {
  std::vector<MethodOnSystem> all;
  for (const MethodEntry& method : method_entries()) {
    std::optional<MethodOnSystem> on = declared_by(method, system_traits<S>, info);
    for_each_type(typename SpecialMethods<S>::type{}, [&]<class Method>(Method*) {
      if (method.traits.name == std::string_view(Method::traits.name))
        on = declared_by<Method, S>(info);
    });
    if (on) all.push_back(*std::move(on));
  }
  return all;
}

}  // namespace stiefel
