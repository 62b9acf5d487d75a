#pragma once

#include <Eigen/Core>

namespace stiefel {

/// A 3D body brought to its principal axes: I = R diag(moments) Rᵀ, det R = +1.
/// Q_caller = Q Rᵀ, M_caller = R M Rᵀ. A diagonal tensor keeps its axes and their order, R = I.
struct PrincipalAxes {
  Eigen::Vector3d moments;
  Eigen::Matrix3d rotation;
};

PrincipalAxes principal_axes(const Eigen::Matrix3d& inertia_tensor);

/// λ_i = ½ tr(I) − I_i, so that I_1 = λ_2 + λ_3 and cyclic.
Eigen::Vector3d inertia_of_moments(const Eigen::Vector3d& moments);

}  // namespace stiefel
