#pragma once

#include "engine/rigid_body/rigid_forms.h"
#include "stiefel/scene.h"

namespace stiefel {

/// Returns the observables of (Q, P), stacked to 2N × N: the blocks, M = (QᵀP − PᵀQ)/ε and the
/// constant PQᵀ, for Side::right M = (PQᵀ − QPᵀ)/ε and PᵀQ, and the invariants of M.
StackedObservables symmetric_observables(const Scene& scene, Side side = Side::left);

}  // namespace stiefel
