#include "engine/methods/special/right_symmetric_rigid_body.h"

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
  return make_simulation(scene, RightSymmetricRigidBody<double>(scene.inertia(), scene.epsilon()),
                         shared(symmetric_observables(scene, Side::right)),
                         rigid_body_cost(scene.dimension()));
}

}  // namespace

SystemEntry right_symmetric_rigid_body_entry() {
  SystemInfo info = rigid_form_info(costate_block(Side::right), true, Side::right);
  info.name = "right_symmetric_rigid_body";
  info.summary = "symmetric representation of the rigid body, right-invariant";
  info.equations = "Q' = Omega Q, P' = Omega P, M = (P Q^T - Q P^T) / epsilon";
  info.source = "[RB] Prop. 3.4";
  info.file = "engine/systems/right_symmetric_rigid_body.h";
  info.methods = methods_on<RightSymmetricRigidBody<double>>(info);
  return {.info = info,
          .check = [](SceneDraft& draft) { check_symmetric(draft, true); },
          .make = make,
          .recommended = for_products,
          .two_forms = {&two_form::of_symmetric_pairs},
          .representation = &representation::right_symmetric_body,
          .motion = &motion_start::right_symmetric_body,
          .rate = Rate::angular_speed};
}

}  // namespace stiefel
