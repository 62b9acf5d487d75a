#pragma once

#include "stiefel/scene.h"

namespace stiefel {

/// Returns the principal axes of an inertia tensor in kg m².
PrincipalAxes principal_axes(const Eigen::Matrix3d& inertia_tensor);

/// Returns λ_i = ½ tr(I) − I_i, so that I_1 = λ_2 + λ_3 and cyclic.
Eigen::Vector3d inertia_of_moments(const Eigen::Vector3d& moments);

}  // namespace stiefel
