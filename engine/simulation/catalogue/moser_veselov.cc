#include "engine/maps/moser_veselov.h"

#include "engine/simulation/catalogue/families/discrete_hamiltonian.h"
#include "engine/simulation/catalogue/families/forms.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_body_observables.h"
#include "engine/simulation/catalogue/families/rigid_body_scene.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/systems/rigid_body.h"
#include "engine/simulation/stepping/methods_on.h"

namespace stiefel {
namespace {

template <class Space, class... MovesFrame>
std::unique_ptr<Simulation> make_in(const Scene& scene, MovesFrame... moves_frame) {
  const MoserVeselov<Space> map(scene.inertia(), scene.step(), Arithmetic::compensated,
                                moves_frame...);
  return make_discrete_simulation(scene, map, rigid_body_observables(scene),
                                  rigid_body_cost(scene.dimension()));
}

std::unique_ptr<Simulation> make(const Scene& scene) {
  if (scene.dimension() == 3) return make_in<So3<double, true>>(scene, scene.has_frame());
  if (scene.dimension() == 4) return make_in<So4<double, true>>(scene, scene.has_frame());
  return make_in<SoN<double>>(scene);
}

}  // namespace

SystemEntry moser_veselov_entry() {
  SystemInfo info = rigid_body_family();
  info.name = "moser_veselov";
  info.summary = "discrete rigid body of Moser and Veselov, its own step as the time";
  info.equations = "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U, M_{k+1} = U^T M_k U";
  info.source = "[RB] (4.5)";
  info.file = "engine/maps/moser_veselov.h";
  info.discrete = true;
  info.invariants.push_back(discrete_hamiltonian_info);
  info.methods = keeps_all(info);
  return {.info = info,
          .check = check_rigid_body_or_engineers,
          .make = make,
          .two_forms = {&two_form::of_bodies},
          .representation = &representation::body,
          .motion = &motion_start::body,
          .rate = Rate::angular_speed,
          .continuous = RigidBody<SoN<double>>::name,
          .packed = true};
}

}  // namespace stiefel
