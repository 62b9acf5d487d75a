#pragma once

#include <Eigen/Core>

namespace stiefel {

class Scene;

// Functions that return how fast a motion changes. They follow it for some rotations by the
// explicit midpoint rule, with momentum and Λ scaled to 1 so that no square overflows, and return 0
// at rest.

/// For a body in four dimensions: returns the mean of (‖M̈‖/‖M‖)^{1/2} over four rotations, as the
/// fourth root of the mean of its fourth powers.
double mean_momentum_rate(const Scene& scene, double angular_speed);

/// For a geodesic on V(1, N): returns the largest (‖q⃛‖/‖q̇‖)^{1/2} in sixteen rotations.
double largest_velocity_rate(const Scene& scene);
/// Returns the instructions that largest_velocity_rate takes in N dimensions.
double velocity_rate_work(Eigen::Index N);

}  // namespace stiefel
