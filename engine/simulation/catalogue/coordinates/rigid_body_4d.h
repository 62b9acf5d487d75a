#pragma once

#include "stiefel/simulation.h"

namespace stiefel {

/// Whether a scene has four dimensions and its states are kept in the coordinates of So4: with a
/// method that declares it (MethodTraits::in_so4), or as a discrete body.
bool is_rigid_body_4d(const Scene& scene);

std::unique_ptr<Simulation> rigid_body_4d(const Scene& scene);
std::unique_ptr<Simulation> moser_veselov_4d(const Scene& scene);

}  // namespace stiefel
