#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include "engine/simulation/catalogue/system_entry.h"
#include "stiefel/catalogue.h"

namespace stiefel::testing {

/// A system and a method on it; rigid bodies in three dimensions have code of their own.
struct Pair {
  std::string system, method;
  int N;
  friend void PrintTo(const Pair& pair, std::ostream* out) {
    *out << pair.system << " " << pair.method << " N=" << pair.N;
  }
};

/// Whether a method on a system is tried with that N.
inline bool in_dimension(std::string_view system, const MethodOnSystem& on, int N) {
  if (on.takes && !on.takes(Eigen::VectorXd::Ones(N))) return false;
  const bool in_3d_only = on.takes && !on.takes(Eigen::VectorXd::Ones(4));
  return N == 4 || in_3d_only || system_entry(system)->packed;
}

/// Whether the method chooses its own steps.
inline bool has_own_steps(std::string_view method) {
  const MethodInfo* info = catalogue().method(method);
  return info != nullptr && info->default_tolerance > 0;
}

/// A step at which the method's errors are seen and stay small over a thousand steps: the system's
/// own, which is meant for order 4 (SystemEntry::example_step), and a tenth of it for a method of
/// lower order that keeps nothing.
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

/// All pairs of the catalogue.
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
