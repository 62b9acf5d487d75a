#include "engine/parametric/parametric_moser_veselov.h"
#include "engine/parametric/parametric_rigid_body.h"
#include "engine/rigid_body/j_d/dual_j_d.h"
#include "engine/stepping/tangent_map_of.h"

namespace stiefel {
namespace {

/// The state fills GL(N) × GL(N).
TangentSpace space(const Scene&) {
  return {TangentSpace::Coordinates::orthonormal,
          [](const Eigen::MatrixXd&, const Eigen::MatrixXd& G) { return G; }};
}

}  // namespace

Tangents parametric_rigid_body_tangents() {
  return {space, [](const Scene& scene, const TangentParameters& at) {
            return make_tangent(
                scene, ParametricRigidBody<Tangent>(at.lambda, scene.parameter(), scene.epsilon()),
                at.h);
          }};
}

Tangents parametric_moser_veselov_tangents() {
  return {space,
          [](const Scene& scene, const TangentParameters& at) -> std::unique_ptr<TangentMap> {
            return std::make_unique<TangentMapOf<ParametricMoserVeselov<Tangent>>>(
                [&] {
                  return ParametricMoserVeselov<Tangent>(at.lambda, at.h, scene.parameter(),
                                                         scene.epsilon());
                },
                scene.substeps());
          }};
}

}  // namespace stiefel
