#pragma once

#include <string_view>
#include <vector>

namespace stiefel {

class Scene;
struct MethodDescription;

/// A method, and the scenes of a system that get it when they name neither a method nor a
/// tolerance. Attitude and momentum then stay within 1e-8 relative over 100 rotations (on V(n, N)
/// times the condition of the motion), at a few times the least work that any method needs for it.
struct Recommendation {
  std::string_view where = {};  ///< "N = 3"; empty: every scene
  /// Whether the recommendation is for a scene; null: for every scene.
  bool (*takes)(const Scene&) = nullptr;
  bool members_only = false;  ///< whether it is for the members of an ensemble alone
  std::string_view method;
  int order = 0;  ///< 0 for a closed form
  std::string_view arithmetic = "plain";
  double tolerance = 0;  ///< for methods that choose their own steps, else 0
  /// Bounds for a substep h, which determine the number of substeps: on |h|‖Ω‖ in the initial
  /// state, for a body in three dimensions on |h| times largest_turning_rate; on |h| times
  /// mean_momentum_rate and largest_velocity_rate (motion_rates.h). 0: no bound.
  double largest_h_omega = 0, largest_h_momentum_rate = 0, largest_h_velocity_rate = 0;

  /// Returns the method with one substep.
  MethodDescription description() const;
  /// Returns the least number of substeps that keeps a scene, which has a method, within the bounds
  /// above.
  int substeps(const Scene& scene) const;
};

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

/// Returns the recommendations of a continuous system (SystemEntry::recommended), in order; the
/// last takes every scene. Empty for any other name.
std::vector<Recommendation> recommended(std::string_view system);

/// Finds the first recommendation of a continuous system that takes every one of several scenes,
/// which are passed one after another.
class Recommender {
 public:
  enum class For { one_scene, members };

  Recommender(std::string_view system, For whom) : left_(recommended(system)) {
    if (whom == For::one_scene) std::erase_if(left_, &Recommendation::members_only);
  }

  /// Takes a scene of the system, with or without a method.
  void take(const Scene& scene);
  Recommendation chosen() const;

 private:
  std::vector<Recommendation> left_;  ///< recommendations that take all scenes so far
};

}  // namespace stiefel
