#include "engine/rigid_body/maps/symmetric_rigid_body_maps.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/symmetric_data.h"
#include "engine/stepping/methods_on.h"
#include "engine/stepping/shared_maps.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_right_symmetric_rigid_body(const Scene& scene) {
  return make_simulation(scene, RightSymmetricRigidBody<double>(scene.inertia(), scene.epsilon()),
                         shared(symmetric_observables(scene, Side::right)));
}

}  // namespace

Simulations right_symmetric_rigid_body_simulations() {
  return {make_right_symmetric_rigid_body, methods_on<RightSymmetricRigidBody<double>>};
}

}  // namespace stiefel
