#include "engine/scene/given_body.h"

#include "engine/dense/decompositions.h"
#include "engine/dense/so_3.h"

namespace stiefel {

GivenBody::GivenBody(const BodyDescription& all, std::size_t b, std::size_t count) {
  const auto part = [=](const std::vector<double>& list, std::size_t each) {
    const auto numbers = std::span(list);
    return numbers.size() == each * count ? numbers.subspan(each * b, each) : numbers;
  };
  tensor = part(all.inertia_tensor, 6);
  moments = part(all.moments, 3);
  attitude = part(all.attitude, 4);
  angular_velocity = part(all.angular_velocity, 3);
}

template <class Scalar>
GivenAxes<Scalar> given_axes(const GivenBody& body) {
  using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;
  const auto given = body.tensor.empty() ? body.moments : body.tensor;
  const auto I = [&](std::size_t k) { return Scalar(given[k]); };
  const bool diagonal = given.size() == 3 || (given[3] == 0 && given[4] == 0 && given[5] == 0);
  if (diagonal) return {Vector3<Scalar>(I(0), I(1), I(2)), Matrix3::Identity()};
  Matrix3 tensor;
  tensor << I(0), I(3), I(4),  //
      I(3), I(1), I(5),        //
      I(4), I(5), I(2);
  auto [values, R] = symmetric_eigen_3<Scalar>(tensor);
  if (R.col(0).dot(R.col(1).cross(R.col(2))) < Scalar(0)) R.col(0) = -R.col(0);
  return {values, R};
}

template GivenAxes<double> given_axes(const GivenBody& body);
template GivenAxes<long double> given_axes(const GivenBody& body);
template GivenAxes<Quad> given_axes(const GivenBody& body);

Eigen::Vector3d inertia_of_moments(const Eigen::Vector3d& I) {
  return Eigen::Vector3d(I(1) + I(2) - I(0), I(2) + I(0) - I(1), I(0) + I(1) - I(2)) / 2;
}

ExtendedBody extended_body(const GivenBody& given, const PrincipalAxes& axes,
                           const Eigen::Vector3d& rounded) {
  using Wide = ExtendedBody::Wide;
  const auto [I, R] = given_axes<Wide>(given);
  const PrincipalMoments3<Wide> inertia(I, Vector3<Wide>(I(1) - I(2), I(2) - I(0), I(0) - I(1)));
  const Vector3<Wide> given_omega = Eigen::Vector3d(given.angular_velocity.data()).cast<Wide>();
  if (R.isIdentity(0) && axes.rotation.isIdentity(0))
    return {inertia, I.cwiseProduct(given_omega) - rounded.cast<Wide>(),
            Eigen::Matrix<Wide, 4, 1>::UnitX()};
  const Eigen::Matrix<Wide, 4, 1> turn = quaternion_of(axes.rotation.cast<Wide>().transpose() * R);
  const Vector3<Wide> omega = R.transpose() * given_omega;
  const Vector3<Wide> m = rotation_matrix<Wide>(turn) * I.cwiseProduct(omega);
  return {inertia, m - rounded.cast<Wide>(), turn};
}

std::optional<ExtendedBody> extended_body(const Scene& scene) {
  if (!scene.axes()) return std::nullopt;
  return extended_body(GivenBody(*scene.description().body), *scene.axes(), vee(scene.M()));
}

}  // namespace stiefel
