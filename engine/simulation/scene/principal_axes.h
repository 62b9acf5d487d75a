#pragma once

#include "stiefel/scene.h"

namespace stiefel {

/// The principal axes of an inertia tensor, kg m².
PrincipalAxes principal_axes(const Eigen::Matrix3d& inertia_tensor);

/// λ_i = ½ tr(I) − I_i, so that I_1 = λ_2 + λ_3 and cyclic.
Eigen::Vector3d inertia_of_moments(const Eigen::Vector3d& moments);

}  // namespace stiefel
