#pragma once

#include "engine/motion/tangent_map.h"

namespace stiefel {

/// Returns the tangent of the discrete rigid bodies, `variational` of every order and
/// `preprocessed_variational`.
std::unique_ptr<TangentMap> discrete_body_tangent(const Scene& scene, const TangentParameters& at);
/// Returns that of the discrete rigid bodies in products of N × N matrices.
std::unique_ptr<TangentMap> large_body_tangent(const Scene& scene, const TangentParameters& at);
/// Returns that of rk4.
std::unique_ptr<TangentMap> rk4_body_tangent(const Scene& scene, const TangentParameters& at);
/// Returns that of the closed form in three dimensions.
std::unique_ptr<TangentMap> exact_body_tangent(const Scene& scene, const TangentParameters& at);

}  // namespace stiefel
