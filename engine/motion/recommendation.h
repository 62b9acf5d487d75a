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

/// Finds the first recommendation of a continuous system that takes every one of several scenes,
/// which are passed one after another.
class Recommender {
 public:
  /// Whether the scenes are one, or the members of an ensemble.
  enum class Scenes { one, members };

  Recommender(std::string_view system, Scenes scenes) : left_(recommended(system)) {
    if (scenes == Scenes::one) std::erase_if(left_, &Recommendation::members_only);
  }

  /// Takes a scene of the system, with or without a method.
  void take(const Scene& scene);
  Recommendation chosen() const;

 private:
  std::vector<Recommendation> left_;  ///< recommendations that take all scenes so far
};

}  // namespace stiefel
