#pragma once

#include "engine/simulation/simulation.h"

namespace stiefel {

/// Whether a scene is one of four dimensions whose states are held in the coordinates of So4: by
/// rk4 and variational, and the discrete body.
bool goes_in_four(const Scene& scene);

std::unique_ptr<Simulation> rigid_body_in_four(const Scene& scene);
std::unique_ptr<Simulation> moser_veselov_in_four(const Scene& scene);

}  // namespace stiefel
