#pragma once

namespace stiefel {

class Scene;

// How fast a motion changes, followed for some rotations by the explicit midpoint rule, with
// momentum and Λ scaled to 1, so that no square overflows. 0 at rest.

/// A body in four dimensions: (‖M̈‖/‖M‖)^{1/2} in the mean of its fourth powers over four rotations.
double mean_momentum_rate(const Scene& scene, double angular_speed);

/// A geodesic on V(1, N): the largest (‖q⃛‖/‖q̇‖)^{1/2} in sixteen rotations.
double largest_velocity_rate(const Scene& scene);

}  // namespace stiefel
