#include "engine/systems/rigid_body.h"

#include "engine/simulation/catalogue/families/exact_body.h"
#include "engine/simulation/catalogue/families/in_float.h"
#include "engine/simulation/catalogue/families/rigid_body_4d.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_body_observables.h"
#include "engine/simulation/catalogue/families/rigid_body_scene.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/run/simulate.h"

namespace stiefel {
namespace {

template <class Space>
std::unique_ptr<Simulation> make_in(const Scene& scene) {
  return simulate(scene, RigidBody<Space>(scene.inertia()), RigidBodyObservables<Space>(scene),
                  rigid_body_cost(scene.dimension()));
}

std::unique_ptr<Simulation> make(const Scene& scene) {
  if (is_rigid_body_4d(scene)) return rigid_body_4d(scene);
  if (scene.in_float()) return rigid_body_in_float(scene);
  if (scene.axes() && scene.method() == Exact::traits.name) return exact_body(scene);
  if (scene.dimension() != 3) return make_in<SoN<double>>(scene);
  if (scene.has_frame()) return make_in<So3<double, true>>(scene);
  return make_in<So3<double, false>>(scene);
}

}  // namespace

SystemEntry rigid_body_entry() {
  SystemInfo info = rigid_body_family();
  info.name = "rigid_body";
  info.summary = "free rigid body in N dimensions";
  info.equations = "Q' = Q Omega, M' = [M, Omega], M = Lambda Omega + Omega Lambda";
  info.source = "[RB] (2.2), (2.3)";
  info.file = "engine/systems/rigid_body.h";
  info.methods = methods_on<RigidBody<SoN<double>>, RigidBody<So3<double, true>>>(info);
  offer_in_float(info);
  return {info, check_rigid_body_or_engineers, make};
}

}  // namespace stiefel
