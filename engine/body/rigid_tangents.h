#pragma once

#include "engine/methods/exact.h"
#include "engine/methods/preprocessed_variational.h"
#include "engine/methods/rk4.h"
#include "engine/methods/variational.h"
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

/// Those of the methods that move bodies, and of the discrete body.
inline constexpr MethodTangent tangents_of_bodies[] = {
    {Exact::traits.name, exact_body_tangent, 3},
    {Variational::traits.name, discrete_body_tangent},
    {PreprocessedVariational::traits.name, discrete_body_tangent},
    {Rk4::traits.name, rk4_body_tangent}};
inline constexpr MethodTangent tangents_of_maps[] = {{"", discrete_body_tangent}};

}  // namespace stiefel
