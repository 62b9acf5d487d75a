#pragma once

#include "engine/motion/body_view.h"
#include "engine/motion/observables.h"

namespace stiefel {

/// Returns the observables of a scene of a view: `body` has those of its (Q, M).
SharedObservables viewed(const Scene& scene, SharedObservables body);

}  // namespace stiefel
