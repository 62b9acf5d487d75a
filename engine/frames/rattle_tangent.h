#pragma once

#include "engine/stepping/tangent_map.h"

namespace stiefel {

/// Returns whether the scene moves by the variational step on V(n, N), of any order, with n at most
/// 6, and its tangents by columns.
bool has_rattle_tangent(const Scene& scene);
std::unique_ptr<TangentMap> rattle_tangent(const Scene& scene, const ColumnParameters& at);
/// Returns those for many columns, which move vectors one by one in packs of columns.
std::unique_ptr<TangentMap> wide_rattle_tangent(const Scene& scene, const ColumnParameters& at);

}  // namespace stiefel
