#include "engine/methods/special/symmetric_rigid_body.h"

#include "engine/simulation/catalogue/families/forms.h"
#include "engine/simulation/catalogue/families/recommended.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_forms.h"
#include "engine/simulation/catalogue/families/symmetric_observables.h"
#include "engine/simulation/catalogue/families/symmetric_scene.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make(const Scene& scene) {
  return make_simulation(scene, SymmetricRigidBody<double>(scene.inertia(), scene.epsilon()),
                         shared(symmetric_observables(scene)), rigid_body_cost(scene.dimension()));
}

}  // namespace

SystemEntry symmetric_rigid_body_entry() {
  SystemInfo info = rigid_form_info(costate_block(), true);
  info.name = "symmetric_rigid_body";
  info.summary = "symmetric representation of the rigid body";
  info.equations = "Q' = Q Omega, P' = P Omega, M = (Q^T P - P^T Q) / epsilon";
  info.source = "[RB] (3.1), Prop. 3.13";
  info.file = "engine/systems/symmetric_rigid_body.h";
  info.methods = methods_on<SymmetricRigidBody<double>>(info);
  return {.info = info,
          .check = [](SceneDraft& draft) { check_symmetric(draft, false); },
          .make = make,
          .recommended = for_products,
          .two_forms = {&two_form::of_symmetric_pairs},
          .dirac_bracket = true,
          .representation = &representation::symmetric_body,
          .motion = &motion_start::symmetric_body,
          .rate = Rate::angular_speed};
}

}  // namespace stiefel
