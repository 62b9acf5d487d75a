#include "engine/rigid_body/moser_veselov/moser_veselov.h"

#include "engine/rigid_body/coordinates/moser_veselov_4d.h"
#include "engine/rigid_body/discrete_hamiltonian.h"
#include "engine/catalogue/forms.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_body_observables.h"
#include "engine/rigid_body/rigid_body_scene.h"
#include "engine/catalogue/motions/motion_starts.h"
#include "engine/catalogue/representations/representations.h"
#include "engine/catalogue/system_entry.h"
#include "engine/stepping/make_simulation.h"
#include "engine/rigid_body/body/rigid_body.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

template <class Space>
std::unique_ptr<Simulation> make_in(const Scene& scene) {
  using Map = MoserVeselov<Space, Arithmetic::compensated>;
  return make_discrete_simulation(scene, Map(scene.inertia(), scene.step()),
                                  RigidBodyObservables<Space>(scene),
                                  rigid_body_cost(scene.dimension()));
}

std::unique_ptr<Simulation> make(const Scene& scene) {
  if (scene.dimension() == 4) return moser_veselov_4d(scene);
  if (scene.dimension() != 3) return make_in<SoN<double>>(scene);
  if (scene.has_frame()) return make_in<So3<double, true>>(scene);
  return make_in<So3<double, false>>(scene);
}

}  // namespace

SystemEntry moser_veselov_entry() {
  SystemInfo info = rigid_body_family();
  info.name = "moser_veselov";
  info.summary = "discrete rigid body of Moser and Veselov, its own step as the time";
  info.equations = "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U, M_{k+1} = U^T M_k U";
  info.source = "[RB] (4.5)";
  info.file = "engine/rigid_body/moser_veselov/moser_veselov.h";
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
