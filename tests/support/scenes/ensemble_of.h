#pragma once

#include <vector>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// The ensemble of scenes that differ in their states and inertia only.
SceneDescription ensemble_of(const std::vector<SceneDescription>& scenes);

}  // namespace stiefel::testing
