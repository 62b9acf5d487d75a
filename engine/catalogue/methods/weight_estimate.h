#pragma once

#include "engine/catalogue/system_entry.h"
#include "stiefel/scene.h"

namespace stiefel {

/// Estimates the instructions of a step of a scene that has no entry in the table: five for each
/// nanosecond that the system's `make` gives for a step, times the relative work of its method.
///
/// The relative work is the work of the method divided by the geometric mean of the work of all
/// methods of the scene's system, as the other systems of the table have them at the size of the
/// scene. It is the geometric mean over the systems that have all these methods; methods that no
/// system of the table has are left out, and have the relative work 1.
double estimated_weight(const Scene& scene, const FrameSize& size);

}  // namespace stiefel
