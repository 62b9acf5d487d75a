#include "engine/linalg/lie/dual_skew_flow.h"
#include "engine/methods/crouch_grossman3.h"
#include "engine/methods/munthe_kaas4.h"
#include "engine/methods/rk4.h"
#include "engine/rigid_body/tangents/steady_tangent.h"
#include "engine/rigid_body/j_d/dual_j_d.h"
#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "engine/rigid_body/symmetric/dual_psi.h"
#include "engine/stepping/tangent_map_of.h"

namespace stiefel {
namespace {

using Methods = TypeList<Variational, PreprocessedVariational, Exact, Splitting, MuntheKaas4,
                         CrouchGrossman3, ImplicitMidpoint, Gauss4, Rk4>;

template <class Space>
std::unique_ptr<TangentMap> by_method(const Scene& scene, const TangentParameters& at) {
  using Body = RigidBody<Space>;
  const Body body(typename Space::Lambda(at.lambda), scene.has_frame());
  const std::string method = scene.method().empty() ? Variational::traits.name : scene.method();
  std::unique_ptr<TangentMap> made;
  for_each_type(Methods{}, [&]<class Method>(Method*) {
    if constexpr (applies<Method, Body>) {
      if (method != Method::traits.name) return;
      if constexpr (has_map_for<Method, Body> || !HasMatrixStates<Body>)
        made = make_tangent_by<Method>(scene, body, at.h);
      else
        made = make_general_tangent(scene, body, at.h);
    }
  });
  return made;
}

TangentSpace space(const Scene&) { return {TangentSpace::Coordinates::left_body, {}}; }

std::unique_ptr<TangentMap> make(const Scene& scene, const TangentParameters& at) {
  if (scene.dimension() == 3 && scene.method() == Exact::traits.name)
    if (auto steady = steady_tangent(scene, at)) return steady;
  return scene.dimension() == 3 ? by_method<So3<Tangent, true>>(scene, at)
                                : by_method<SoN<Tangent>>(scene, at);
}

}  // namespace

Tangents rigid_body_tangents() {
  return {space, make, [](const Scene& scene) -> MatrixSystem<Tangent> {
            return RigidBody<SoN<Tangent>>(scene.inertia().cast<Tangent>(), scene.has_frame());
          }};
}
Tangents moser_veselov_tangents() { return {space, make}; }

}  // namespace stiefel
