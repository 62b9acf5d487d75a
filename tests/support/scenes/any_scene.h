#pragma once

#include <string>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// A seeded scene of any system in the catalogue, small (N = 4; n = 2 of 5), full and not
/// commuting, h times the rate about `step`. An empty method makes it one of a discrete system.
SceneDescription any_scene(const std::string& system, const std::string& method, unsigned seed,
                           double step, int N = 4);

}  // namespace stiefel::testing
