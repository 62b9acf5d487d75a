#pragma once

#include "engine/motion/tangent_map.h"
#include "stiefel/violation.h"

namespace stiefel {

/// Returns the tangents of a system; null if it has none.
const Tangents* tangents_of(std::string_view system);
/// Returns the tangent of a method for the scene's system and dimension; null if it has none.
const MethodTangent* tangent_of(const Scene& scene, std::string_view method);
/// Returns the refusal of a scene that has no tangent, an ensemble or one by its method, which
/// names the methods that have one; empty if it has one.
Violations without_tangent(const Scene& scene);

}  // namespace stiefel
