#pragma once

#include <vector>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// Returns the ensemble of scenes that differ only in their states and inertia.
SceneDescription ensemble_of(const std::vector<SceneDescription>& scenes);

}  // namespace stiefel::testing
