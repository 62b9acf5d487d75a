#pragma once

#include "engine/stepping/tangent_map.h"

namespace stiefel {

// Tangents of the rigid body that move all vectors together, by the linearised formulas of a step.

/// Returns those of the discrete rigid bodies, `variational` of every order and
/// `preprocessed_variational`.
std::unique_ptr<TangentMap> discrete_body_tangent(const Scene& scene, const ColumnParameters& at);
/// Returns those of the discrete rigid bodies in products of N × N matrices.
std::unique_ptr<TangentMap> large_body_tangent(const Scene& scene, const ColumnParameters& at);
/// Returns those of rk4, for N up to 10.
std::unique_ptr<TangentMap> rk4_body_tangent(const Scene& scene, const ColumnParameters& at);
/// Returns those of rk4 in three dimensions, where Q is a quaternion.
std::unique_ptr<TangentMap> rk4_body_tangent_3(const Scene& scene, const ColumnParameters& at);

}  // namespace stiefel
