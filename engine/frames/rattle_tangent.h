#pragma once

#include "engine/stepping/tangent_map.h"

namespace stiefel {

/// Returns the tangents of the variational step on V(n, N) by columns, for every order; null for n
/// above 6.
std::unique_ptr<TangentMap> rattle_tangent(const Scene& scene, const ColumnParameters& at);
/// Returns those for many columns, which move vectors one by one in packs of columns.
std::unique_ptr<TangentMap> wide_rattle_tangent(const Scene& scene, const ColumnParameters& at);

}  // namespace stiefel
