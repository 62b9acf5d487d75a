#pragma once

#include "engine/stepping/tangent_map.h"

namespace stiefel {

/// Returns the tangents of the closed form in three dimensions where the scene's rotation is
/// steady, m × ω = 0; else null. EulerTop has a formula of its own for these motions, whose
/// derivative is not that of the motions beside them.
std::unique_ptr<TangentMap> steady_tangent(const Scene& scene, const TangentParameters& at);

}  // namespace stiefel
