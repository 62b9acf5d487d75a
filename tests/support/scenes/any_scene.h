#pragma once

#include <string>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// Returns a seeded scene of any system in the catalogue. It is small (N = 4; n = 2 of 5), its
/// matrices are full and do not commute, and h times the rate is about `step`. `method` is empty
/// for a discrete system.
SceneDescription any_scene(const std::string& system, const std::string& method, unsigned seed,
                           double step, int N = 4);

}  // namespace stiefel::testing
