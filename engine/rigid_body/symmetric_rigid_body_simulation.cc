#include "engine/rigid_body/maps/symmetric_rigid_body_maps.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/symmetric_data.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_symmetric_rigid_body(const Scene& scene) {
  return make_simulation(scene, SymmetricRigidBody<double>(scene.inertia(), scene.epsilon()),
                         shared(symmetric_observables(scene)));
}

}  // namespace

Simulations symmetric_rigid_body_simulations() {
  return {make_symmetric_rigid_body, methods_on<SymmetricRigidBody<double>>};
}

}  // namespace stiefel
