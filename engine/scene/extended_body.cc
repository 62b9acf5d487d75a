#include "engine/scene/extended_body.h"

#include "engine/linalg/lie/so_3.h"
#include "engine/scene/given_axes.h"

namespace stiefel {
std::optional<ExtendedBody> extended_body(const Scene& scene) {
  if (!scene.description().body) return std::nullopt;
  using Wide = ExtendedBody::Wide;
  const BodyDescription& body = *scene.description().body;
  const auto [I, R] = given_axes<Wide>(body);
  const Eigen::Matrix<Wide, 4, 1> axes =
      quaternion_of(scene.axes()->rotation.cast<Wide>().transpose() * R);
  const Vector3<Wide> omega =
      R.transpose() * Eigen::Vector3d(body.angular_velocity.data()).cast<Wide>();
  const Vector3<Wide> m = rotation_matrix<Wide>(axes) * I.cwiseProduct(omega);
  return ExtendedBody{
      {I, Vector3<Wide>(I(1) - I(2), I(2) - I(0), I(0) - I(1))},
      m - vee(scene.M()).cast<Wide>(),
      axes,
  };
}

}  // namespace stiefel
