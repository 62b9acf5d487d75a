#pragma once

#include "engine/catalogue/body_view.h"
#include "engine/stepping/observables.h"

namespace stiefel {

/// Returns the observables of a scene of a view: `body` has those of its (Q, M).
SharedObservables viewed(const Scene& scene, SharedObservables body);

}  // namespace stiefel
