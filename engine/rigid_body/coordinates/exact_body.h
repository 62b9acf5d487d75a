#pragma once

#include <memory>

#include "stiefel/simulation.h"

namespace stiefel {

/// Whether a scene is given by `body` and its method is the closed form.
bool is_exact_body(const Scene& scene);

/// Returns the simulation of a scene given by `body` with the method `exact`. It moves the body
/// with the caller's numbers; other methods start from Λ and M rounded to doubles.
std::unique_ptr<Simulation> exact_body(const Scene& scene);

}  // namespace stiefel
