#pragma once

#include <Eigen/Eigenvalues>

#include "engine/linalg/arithmetic/scalar.h"
#include "stiefel/scene.h"

namespace stiefel {

/// The principal axes of a body whose numbers are doubles, in Scalar: I = R diag(moments) Rᵀ,
/// det R = +1. Moments and a diagonal tensor keep their axes and their order, R = 1.
template <class Scalar>
struct GivenAxes {
  Vector3<Scalar> moments;
  Eigen::Matrix<Scalar, 3, 3> rotation;
};

template <class Scalar>
GivenAxes<Scalar> given_axes(const BodyDescription& body) {
  using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;
  const auto& given = body.inertia_tensor.empty() ? body.moments : body.inertia_tensor;
  const auto I = [&](std::size_t k) { return Scalar(given[k]); };
  const bool diagonal = given.size() == 3 || (given[3] == 0 && given[4] == 0 && given[5] == 0);
  if (diagonal) return {Vector3<Scalar>(I(0), I(1), I(2)), Matrix3::Identity()};
  Matrix3 tensor;
  tensor << I(0), I(3), I(4),  //
      I(3), I(1), I(5),        //
      I(4), I(5), I(2);
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(tensor);
  Matrix3 R = solver.eigenvectors();
  if (R.col(0).dot(R.col(1).cross(R.col(2))) < Scalar(0)) R.col(0) = -R.col(0);
  return {solver.eigenvalues(), R};
}

}  // namespace stiefel
