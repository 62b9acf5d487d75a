#pragma once

#include "engine/stepping/tangent_map.h"

namespace stiefel {

/// Returns the tangents by columns of the discrete rigid bodies, `variational` of every order and
/// `preprocessed_variational`; null for N above 10 and for other methods.
std::unique_ptr<TangentMap> discrete_body_tangent(const Scene& scene, const ColumnParameters& at);

}  // namespace stiefel
