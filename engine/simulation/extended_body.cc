#include "engine/simulation/extended_body.h"

#include <Eigen/Eigenvalues>

#include "engine/linalg/so_3.h"

namespace stiefel {
namespace {

using Wide = ExtendedBody::Wide;
using Matrix3 = Eigen::Matrix<Wide, 3, 3>;

Matrix3 inertia_tensor(const BodyDescription& body) {
  const auto& I = body.inertia_tensor;
  Matrix3 tensor;
  tensor << I[0], I[3], I[4],  //
      I[3], I[1], I[5],        //
      I[4], I[5], I[2];
  return tensor;
}

}  // namespace

std::optional<ExtendedBody> extended_body(const Scene& scene) {
  if (!scene.description().body) return std::nullopt;
  const BodyDescription& body = *scene.description().body;
  const Matrix3 R_scene = scene.axes()->rotation.cast<Wide>();
  Vector3<Wide> I = scene.axes()->moments.cast<Wide>();
  Matrix3 R = R_scene;
  if (!body.inertia_tensor.empty() && !inertia_tensor(body).isDiagonal(0)) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(inertia_tensor(body));
    I = solver.eigenvalues();
    R = solver.eigenvectors();
    if (R.determinant() < 0) R.col(0) = -R.col(0);
  }
  const Eigen::Matrix<Wide, 4, 1> axes = quaternion_of(R_scene.transpose() * R);
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
