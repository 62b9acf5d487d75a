#include "engine/simulation/catalogue/coordinates/in_float.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_body_observables.h"
#include "engine/simulation/stepping/simulate.h"
#include "engine/simulation/stepping/stored_as.h"
#include "engine/systems/rigid_body.h"

namespace stiefel {
namespace {

template <class Space, class Wide>
std::unique_ptr<Simulation> make_in(const Scene& scene) {
  using Observables = RigidBodyObservables<Wide>;
  using Stored = StoredAs<SinglePrecision<typename Observables::Point>, Observables>;
  return simulate<MethodsInFloat>(scene, RigidBody<Space>(rounded_to<float>(scene.inertia())),
                                  Stored(Observables(scene)), rigid_body_cost(scene.dimension()));
}

}  // namespace

std::unique_ptr<Simulation> rigid_body_in_float(const Scene& scene) {
  if (scene.dimension() != 3) return make_in<SoN<float>, SoN<double>>(scene);
  if (scene.has_frame()) return make_in<So3<float, true>, So3<double, true>>(scene);
  return make_in<So3<float, false>, So3<double, false>>(scene);
}

}  // namespace stiefel
