#pragma once

#include <memory>

#include "engine/simulation/simulation.h"

namespace stiefel {

/// The scene, given by `body`, in the hands of the method `exact`: the motion of the body as it was
/// given, not of the rounded Λ and M that other methods start from.
std::unique_ptr<Simulation> exact_body(const Scene& scene);

}  // namespace stiefel
