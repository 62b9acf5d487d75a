#include "engine/rigid_body/maps/right_rigid_body_maps.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_forms.h"
#include "engine/stepping/methods_on.h"
#include "engine/stepping/shared_maps.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_right_rigid_body(const Scene& scene) {
  const int N = scene.dimension();
  StackedObservables observables(stacked(scene, "Q", "M"));
  observables.block("Q", 0, N).block("M", N, N);
  report_rigid_form(observables, scene,
                    {.Q = [N](const auto& x) { return x.topRows(N).eval(); },
                     .M = [N](const auto& x) { return x.bottomRows(N).eval(); },
                     .side = Side::right});
  return make_simulation(scene, RightRigidBody<double>(scene.inertia()), shared(observables));
}

}  // namespace

Simulations right_rigid_body_simulations() {
  return {make_right_rigid_body, methods_on<RightRigidBody<double>>};
}

}  // namespace stiefel
