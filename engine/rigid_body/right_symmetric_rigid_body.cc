#include "engine/rigid_body/maps/right_symmetric_rigid_body_maps.h"

#include "engine/catalogue/forms.h"
#include "engine/catalogue/methods/recommended.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_forms.h"
#include "engine/rigid_body/symmetric_observables.h"
#include "engine/rigid_body/symmetric_scene.h"
#include "engine/catalogue/motions/motion_starts.h"
#include "engine/catalogue/representations/representations.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make(const Scene& scene) {
  return make_simulation(scene, RightSymmetricRigidBody<double>(scene.inertia(), scene.epsilon()),
                         symmetric_observables(scene, Side::right),
                         rigid_body_cost(scene.dimension()));
}

}  // namespace

SystemEntry right_symmetric_rigid_body_entry() {
  SystemInfo info = rigid_form_info(costate_block(Side::right), true, Side::right);
  info.name = "right_symmetric_rigid_body";
  info.summary = "symmetric representation of the rigid body, right-invariant";
  info.equations = "Q' = Omega Q, P' = Omega P, M = (P Q^T - Q P^T) / epsilon";
  info.source = "[RB] Prop. 3.4";
  info.file = "engine/rigid_body/symmetric/right_symmetric_rigid_body.h";
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
