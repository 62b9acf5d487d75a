#include "engine/rigid_body/parametric/parametric_forms.h"
#include "engine/rigid_body/parametric/parametric_rigid_body.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_parametric_rigid_body(const Scene& scene) {
  return make_simulation(
      scene, ParametricRigidBody<double>(scene.inertia(), scene.parameter(), scene.epsilon()),
      shared(parametric_observables(scene, 1)));
}

}  // namespace

Simulations parametric_rigid_body_simulations() {
  return {make_parametric_rigid_body, methods_on<ParametricRigidBody<double>>};
}

}  // namespace stiefel
