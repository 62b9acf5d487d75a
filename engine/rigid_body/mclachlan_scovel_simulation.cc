#include "engine/rigid_body/maps/turned_bodies.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_forms.h"
#include "engine/rigid_body/symmetric/mclachlan_scovel_blocks.h"
#include "engine/stepping/methods_on.h"
#include "engine/stepping/shared_maps.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_mclachlan_scovel(const Scene& scene) {
  const int N = scene.dimension();
  StackedObservables observables(stacked(scene, "Q", "B"));
  observables.block("Q", 0, N).block("B", N, N);
  report_rigid_form(
      observables, scene,
      {.Q = [N](const auto& x) { return x.topRows(N).eval(); },
       .M = [N](const auto& x) { return M_of_B<double>(x.topRows(N), x.bottomRows(N)); }});
  return make_simulation(scene, McLachlanScovel<double>(scene.inertia()), shared(observables));
}

}  // namespace

Simulations mclachlan_scovel_simulations() {
  return {make_mclachlan_scovel, methods_on<McLachlanScovel<double>>};
}

}  // namespace stiefel
