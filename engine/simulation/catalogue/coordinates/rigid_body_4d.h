#pragma once

#include "stiefel/simulation.h"

namespace stiefel {

/// Whether a scene is one of four dimensions whose states are held in the coordinates of So4: that
/// of a method that declares it (MethodTraits::in_so4), or the discrete body.
bool is_rigid_body_4d(const Scene& scene);

std::unique_ptr<Simulation> rigid_body_4d(const Scene& scene);
std::unique_ptr<Simulation> moser_veselov_4d(const Scene& scene);

}  // namespace stiefel
