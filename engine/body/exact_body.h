#pragma once

#include <memory>
#include <span>

#include "engine/body/exact/top_in_time.h"
#include "engine/scene/given_body.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// Whether a scene of a rigid body has the method `exact` and three dimensions.
bool is_exact_body(const Scene& scene);

/// Returns the simulation of such a scene. A body given by `body` moves with the caller's numbers;
/// other methods start from Λ and M rounded to doubles.
std::unique_ptr<Simulation> exact_body(const Scene& scene);

/// Returns the motion of such a body from (q; m), or from m where it has no frame.
TopInTime top_in_time(const Eigen::Vector3d& lambda, const std::optional<ExtendedBody>& given,
                      std::span<const double> state);

}  // namespace stiefel
