#include "engine/scene/given_axes.h"

#include <Eigen/Eigenvalues>

namespace stiefel {

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

template GivenAxes<long double> given_axes(const BodyDescription& body);
template GivenAxes<Quad> given_axes(const BodyDescription& body);

}  // namespace stiefel
