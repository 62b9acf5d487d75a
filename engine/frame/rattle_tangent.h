#pragma once

#include "engine/motion/tangent_map.h"

namespace stiefel {

/// Returns the tangent of the variational step on V(n, N), of any order.
std::unique_ptr<TangentMap> rattle_tangent(const Scene& scene, const TangentParameters& at);

}  // namespace stiefel
