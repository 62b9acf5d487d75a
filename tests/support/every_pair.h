#pragma once

#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

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
  return N == 4 || in_3d_only || system == "rigid_body" || system == "moser_veselov";
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
