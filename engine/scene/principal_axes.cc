#include "engine/scene/principal_axes.h"

#include <Eigen/Eigenvalues>

namespace stiefel {

PrincipalAxes principal_axes(const Eigen::Matrix3d& inertia_tensor) {
  if (inertia_tensor.isDiagonal(0)) return {inertia_tensor.diagonal(), Eigen::Matrix3d::Identity()};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia_tensor);
  Eigen::Matrix3d R = solver.eigenvectors();
  if (R.determinant() < 0) R.col(0) = -R.col(0);
  return {solver.eigenvalues(), R};
}

Eigen::Vector3d inertia_of_moments(const Eigen::Vector3d& I) {
  return Eigen::Vector3d(I(1) + I(2) - I(0), I(2) + I(0) - I(1), I(0) + I(1) - I(2)) / 2;
}

}  // namespace stiefel
