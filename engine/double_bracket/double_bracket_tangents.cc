#include "engine/double_bracket/double_bracket.h"
#include "engine/stepping/tangent_map_of.h"

namespace stiefel {

/// The state fills the space of pairs of complex matrices.
Tangents double_bracket_tangents() {
  return {[](const Scene&) {
            return TangentSpace{TangentSpace::Coordinates::orthonormal,
                                [](const Eigen::MatrixXd&, const Eigen::MatrixXd& G) { return G; }};
          },
          [](const Scene& scene, const TangentParameters& at) {
            const auto p = static_cast<Eigen::Index>(scene.description().inertia_u.size());
            return make_tangent(
                scene,
                DoubleBracket<Tangent>(at.lambda.head(p), at.lambda.tail(at.lambda.size() - p)),
                at.h);
          }};
}

}  // namespace stiefel
