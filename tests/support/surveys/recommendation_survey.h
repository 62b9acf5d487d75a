#pragma once

#include <optional>
#include <string>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// Returns a seeded random scene of any continuous system, without a method, N ≤ `largest_N`. Λ is
/// spread over 1 : 3 … 1 : 100, in a tenth of the scenes with one or two values only; units are
/// random, h‖Ω‖ = 0.05 … 0.3, and half of the scenes have h < 0.
SceneDescription scene_without_method(const std::string& system, unsigned seed, int largest_N);

/// What makes a body hard for a method.
enum class Hard {
  nearly_equal,         ///< Λ = 1 + 1e-6 · random
  wide,                 ///< Λ spread over 1 : 10⁴
  next_to_equilibrium,  ///< a rotation in the plane of the middle λ_i + λ_j, which is unstable,
                        ///< with a relative change of 1e-6
};
/// Returns a seeded random scene of a system of rigid bodies, without a method, 3 ≤ N ≤
/// `largest_N`.
SceneDescription hard_scene(const std::string& system, Hard kind, unsigned seed, int largest_N);

/// Error and cost of the recommended method on a scene of `scene_without_method`, over 100
/// rotations, t = 100 · 2π/‖Ω‖.
struct RecommendationOutcome {
  std::string scene, method;
  /// The larger of the errors of attitude and momentum against the reference, each relative to its
  /// largest element.
  double error = 0;
  double reference_error = 0;
  /// The growth factor of a tiny change of the initial momentum: on V(n, N) at the end, for a hard
  /// scene the largest up to the end; 1 elsewhere.
  double condition = 1;
  /// The work, divided by that of the cheapest entry of the trade-off whose error is within
  /// 1e-8 · condition; 1 if none is cheaper.
  double cost = 1;
  std::string cheapest;
};

/// The largest cost that is accepted: 3, and 10 for a closed form, which is recommended because it
/// is right at the hardest places too, where the cheapest entry is not.
inline double most_cost(const RecommendationOutcome& outcome) {
  return outcome.method.starts_with("exact") ? 10 : 3;
}

/// Measures the recommended method on a scene, or `method` if it is given.
RecommendationOutcome survey_recommendation(const SceneDescription& description,
                                            const std::optional<MethodDescription>& method = {});
/// Measures the error and the condition alone, not the cost.
RecommendationOutcome survey_hard_scene(const SceneDescription& description);

}  // namespace stiefel::testing
