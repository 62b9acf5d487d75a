#pragma once

#include "engine/stepping/tangent_map.h"

namespace stiefel {

/// Returns the tangents by columns of rk4 on the rigid body; null for N above 10.
std::unique_ptr<TangentMap> rk4_body_tangent(const Scene& scene, const ColumnParameters& at);
/// Returns those of rk4 in three dimensions, where Q is a quaternion.
std::unique_ptr<TangentMap> rk4_body_tangent_3(const Scene& scene, const ColumnParameters& at);

}  // namespace stiefel
