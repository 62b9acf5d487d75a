#include "engine/methods/special/turned_bodies.h"

#include "engine/representations/mclachlan_scovel.h"
#include "engine/simulation/catalogue/families/recommended.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_forms.h"
#include "engine/simulation/catalogue/families/symmetric_scene.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make(const Scene& scene) {
  const int N = scene.dimension();
  StackedObservables observables(stacked(scene, "Q", "B"));
  observables.block("Q", 0, N).block("B", N, N);
  report_rigid_form(
      observables, scene,
      {.Q = [N](const auto& x) { return x.topRows(N).eval(); },
       .M = [N](const auto& x) { return M_of_B<double>(x.topRows(N), x.bottomRows(N)); }});
  return make_simulation(scene, McLachlanScovel<double>(scene.inertia()), shared(observables),
                         rigid_body_cost(N));
}

}  // namespace

SystemEntry mclachlan_scovel_entry() {
  SystemInfo info = rigid_form_info({"B", "N x N", false, "B = Q M, so that Q^T B is skew"}, false);
  info.name = "mclachlan_scovel";
  info.summary = "rigid body in the variables of McLachlan and Scovel";
  info.equations = "Q' = Q J^-1(Q^T B), B' = B J^-1(Q^T B), M = Q^T B";
  info.source = "[RB] (5.5)";
  info.file = "engine/systems/mclachlan_scovel.h";
  info.methods = methods_on<McLachlanScovel<double>>(info);
  return {.info = info,
          .check = check_mclachlan_scovel,
          .make = make,
          .recommended = for_products,
          .representation = &representation::mclachlan_scovel,
          .motion = &motion_start::mclachlan_scovel,
          .rate = Rate::angular_speed};
}

}  // namespace stiefel
