#pragma once

#include <vector>

#include "stiefel/catalogue.h"

namespace stiefel {

/// Returns a recommendation of steps with error control. In steps longer than h||Omega|| = 0.5
/// rounding would exceed the tolerance of a single stride.
constexpr Recommendation with_error_control(double tolerance, double largest_h_omega = 0.5) {
  return {
      .method = "adaptive", .order = 8, .tolerance = tolerance, .largest_h_omega = largest_h_omega};
}

/// Returns a recommendation for those scenes that `takes` accepts.
constexpr Recommendation restricted(std::string_view where, bool (*takes)(const Scene&),
                                    Recommendation to) {
  to.where = where;
  to.takes = takes;
  return to;
}

/// Keeps those recommendations that take a scene, with or without a method.
void keep_what_takes(const Scene& scene, std::vector<Recommendation>& left);

}  // namespace stiefel
