#pragma once

#include <optional>

#include "stiefel/scene.h"

namespace stiefel {

/// A rigid body in three dimensions at step 0, (Q, M) along its principal axes, as numbers. An
/// ensemble has one for each member in place of a Scene.
struct Body3 {
  Eigen::Vector3d lambda;
  Eigen::Vector3d m;  ///< the vector of M
  bool has_frame = true;
  int determinant = 1;                                  ///< det Q
  Eigen::Vector4d attitude = Eigen::Vector4d::UnitX();  ///< the quaternion of det(Q) Q
  std::optional<PrincipalAxes> axes = {};               ///< of a body given by `body`
};

}  // namespace stiefel
