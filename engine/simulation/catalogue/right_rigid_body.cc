#include "engine/methods/special/right_rigid_body.h"

#include "engine/simulation/catalogue/families/recommended.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_body_scene.h"
#include "engine/simulation/catalogue/families/rigid_forms.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make(const Scene& scene) {
  const int N = scene.dimension();
  StackedObservables observables(stacked(scene, "Q", "M"));
  observables.block("Q", 0, N).block("M", N, N);
  report_rigid_form(observables, scene,
                    {.Q = [N](const auto& x) { return x.topRows(N).eval(); },
                     .M = [N](const auto& x) { return x.bottomRows(N).eval(); },
                     .side = Side::right});
  return make_simulation(scene, RightRigidBody<double>(scene.inertia()), shared(observables),
                         rigid_body_cost(N));
}

constexpr std::array recommendations = {closed_form_of_body, with_error_control(1e-12, 0.15)};

}  // namespace

SystemEntry right_rigid_body_entry() {
  SystemInfo info = rigid_form_info({"M", "N x N", true, "momentum, skew"}, false, Side::right);
  info.name = "right_rigid_body";
  info.summary = "free rigid body in N dimensions, right-invariant";
  info.equations = "Q' = Omega Q, M' = [Omega, M], M = Lambda Omega + Omega Lambda";
  info.source = "[RB] (RightRBn), Prop. 2.1";
  info.file = "engine/systems/right_rigid_body.h";
  info.methods = methods_on<RightRigidBody<double>>(info);
  return {.info = info,
          .check = [](SceneDraft& draft) { check_rigid_body(draft, true); },
          .make = make,
          .recommended = recommendations,
          .representation = &representation::right_body,
          .motion = &motion_start::right_body,
          .rate = Rate::angular_speed};
}

}  // namespace stiefel
