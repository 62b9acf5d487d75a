#pragma once

#include <memory>

#include "stiefel/simulation.h"

namespace stiefel {

/// Whether a scene is given by `body` and moved by its closed form.
bool is_exact_body(const Scene& scene);

/// The simulation of a scene given by `body` with the method `exact`. It moves the body as it was
/// given; other methods start from Λ and M rounded to doubles.
std::unique_ptr<Simulation> exact_body(const Scene& scene);

}  // namespace stiefel
