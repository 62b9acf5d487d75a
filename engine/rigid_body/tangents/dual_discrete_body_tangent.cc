#include "engine/rigid_body/j_d/dual_j_d.h"
#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "engine/rigid_body/tangents/dual_body_tangents.h"

namespace stiefel {

std::unique_ptr<TangentMap> dual_discrete_body_tangent(const Scene& scene,
                                                       const TangentParameters& at) {
  return make_tangent_by<Variational>(scene, RigidBody<SoN<Tangent>>(at.lambda), at.h);
}

}  // namespace stiefel
