#pragma once

#include <optional>
#include <string>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// A seeded random scene without a method of any continuous system, N ≤ `largest_N`: Λ spread over
/// 1 : 3 … 1 : 100, a tenth of them of two values or one, in random units, h‖Ω‖ = 0.05 … 0.3, half
/// of them with h < 0.
SceneDescription scene_without_method(const std::string& system, unsigned seed, int largest_N);

/// Error and cost of the recommended method on such a scene over 100 rotations, t = 100 · 2π/‖Ω‖.
struct RecommendationOutcome {
  std::string scene, method;
  /// The error of attitude and momentum, each relative to its largest element, against the
  /// reference.
  double error = 0;
  double reference_error = 0;
  /// The growth of a tiny change of the initial state on V(n, N); 1 elsewhere.
  double condition = 1;
  /// The work, divided by that of the cheapest entry of the trade-off within 1e-8 · condition; 1
  /// where none is cheaper.
  double cost = 1;
  std::string cheapest;
};

/// `method`: instead of the recommended one.
RecommendationOutcome survey_recommendation(const SceneDescription& description,
                                            const std::optional<MethodDescription>& method = {});

}  // namespace stiefel::testing
