#include "engine/rigid_body/tangents/dual_body_tangents.h"

#include "engine/methods/munthe_kaas4.h"
#include "engine/rigid_body/j_d/dual_j_d.h"
#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "engine/rigid_body/symmetric/dual_psi.h"

namespace stiefel {

std::unique_ptr<TangentMap> dual_body_tangent_3(const Scene& scene, const TangentParameters& at) {
  return body_tangent_by<So3<Tangent, true>, Splitting, MuntheKaas4, ImplicitMidpoint, Gauss4>(
      scene, at);
}

}  // namespace stiefel
