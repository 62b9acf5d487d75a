#pragma once

#include <memory>

#include "engine/simulation/stepping/observables.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// Returns the simulation in single precision of a geodesic on V(n, N), with the observables of the
/// scene in double precision.
std::unique_ptr<Simulation> stiefel_in_float(const Scene& scene,
                                             const SharedObservables& observables);

}  // namespace stiefel
