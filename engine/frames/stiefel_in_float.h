#pragma once

#include <memory>

#include "engine/stepping/stacked_observables.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// Returns the simulation in single precision of a geodesic on V(n, N), with the observables of the
/// scene in double precision.
std::unique_ptr<Simulation> stiefel_in_float(const Scene& scene,
                                             const StackedObservables& observables);

}  // namespace stiefel
