#pragma once

#include <string_view>
#include <vector>

namespace stiefel {

class Scene;
struct MethodDescription;

/// A method, and the scenes of a system that get it when they name neither a method nor a
/// tolerance: attitude and momentum then stay within 1e-8 relative over 100 rotations (on V(n, N)
/// times the condition of the motion), at a few times the least work that any method needs for it.
struct Recommendation {
  std::string_view where = {};            ///< "N = 3"; empty: every scene
  bool (*takes)(const Scene&) = nullptr;  ///< the same; null: every one
  std::string_view method;
  int order = 0;  ///< 0 of a closed form
  std::string_view arithmetic = "plain";
  double tolerance = 0;  ///< of methods that choose their own steps, else 0
  /// Bounds for a substep h, which determine the number of substeps: on |h|‖Ω‖ in the initial
  /// state; on |h| times mean_momentum_rate and largest_velocity_rate (motion_rates.h). 0: no
  /// bound.
  double largest_h_omega = 0, largest_h_momentum_rate = 0, largest_h_velocity_rate = 0;

  /// The method with one substep.
  MethodDescription description() const;
  /// The least number of substeps that keeps a scene, which has a method, within the bounds above.
  int substeps(const Scene& scene) const;
};

/// The recommendations of a continuous system (SystemEntry::recommended), in order; the last takes
/// every scene. None of another name.
std::vector<Recommendation> recommended(std::string_view system);

/// Finds the first recommendation of a continuous system that takes each of some scenes, which come
/// one after another.
class Recommender {
 public:
  explicit Recommender(std::string_view system) : left_(recommended(system)) {}

  /// A scene of the system, with or without a method.
  void take(const Scene& scene);
  Recommendation chosen() const;

 private:
  std::vector<Recommendation> left_;  ///< those that take all scenes so far
};

}  // namespace stiefel
