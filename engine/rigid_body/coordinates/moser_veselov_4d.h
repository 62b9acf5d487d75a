#pragma once

#include <memory>

#include "stiefel/simulation.h"

namespace stiefel {

/// Returns the simulation of the discrete body with N = 4, in the coordinates of So4.
std::unique_ptr<Simulation> moser_veselov_4d(const Scene& scene);

}  // namespace stiefel
