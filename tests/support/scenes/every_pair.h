#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include "engine/motion/system_entry.h"
#include "stiefel/catalogue.h"

namespace stiefel::testing {

/// A system, a method and a dimension. Both N = 3 and N = 4 occur, because rigid bodies in three
/// dimensions have separate code.
struct Pair {
  std::string system, method;
  int N;
  friend void PrintTo(const Pair& pair, std::ostream* out) {
    *out << pair.system << " " << pair.method << " N=" << pair.N;
  }
};

/// Returns whether a method is tested on a system with this N.
inline bool in_dimension(std::string_view system, const MethodOnSystem& on, int N) {
  if (on.takes && !on.takes(Eigen::VectorXd::Ones(N))) return false;
  const bool in_3d_only = on.takes && !on.takes(Eigen::VectorXd::Ones(4));
  return N == 4 || in_3d_only || system_entry(system)->packs;
}

/// Returns whether the method chooses its own steps.
inline bool has_own_steps(std::string_view method) {
  const MethodInfo* info = catalogue().method(method);
  return info != nullptr && info->default_tolerance > 0;
}

/// Returns a step at which the method's errors are visible and stay small over a thousand steps:
/// the system's SystemEntry::example_step, which suits order 4, and a tenth of it for a method of
/// order 1 or 2 that keeps no invariant.
inline double step_of(std::string_view system, std::string_view method) {
  const SystemEntry& entry = *system_entry(system);
  for (const MethodOnSystem& on : entry.info.methods) {
    const MethodInfo* info = catalogue().method(on.method);
    if (on.method != method || info == nullptr || info->orders.empty()) continue;
    const bool keeps_nothing = std::ranges::all_of(
        on.preserves, [](const Preservation& p) { return p.conservation == Conservation::drifts; });
    if (keeps_nothing && info->default_order < 3) return entry.example_step / 10;
  }
  return entry.example_step;
}

/// Returns all pairs of the catalogue.
inline std::vector<Pair> every_pair() {
  std::vector<Pair> all;
  for (const auto& system : catalogue().systems)
    for (const auto& method : system.methods)
      for (const int N : {3, 4})
        if (in_dimension(system.name, method, N))
          all.push_back({std::string(system.name), std::string(method.method), N});
  return all;
}

inline std::string name_of(const ::testing::TestParamInfo<Pair>& which) {
  const auto& [system, method, N] = which.param;
  return system + (method.empty() ? "" : "_" + method) + (N == 3 ? "_in_3D" : "");
}

}  // namespace stiefel::testing
