#include "engine/systems/parametric_rigid_body.h"

#include "engine/simulation/catalogue/families/parametric_forms.h"
#include "engine/simulation/catalogue/families/recommended.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"

namespace stiefel {
namespace {

constexpr std::array recommendations = {at_constant_Omega, with_error_control(5e-14, 0.1)};

std::unique_ptr<Simulation> make(const Scene& scene) {
  return make_simulation(
      scene, ParametricRigidBody<double>(scene.inertia(), scene.parameter(), scene.epsilon()),
      shared(parametric_observables(scene, 1)), 2 * rigid_body_cost(scene.dimension()));
}

}  // namespace

SystemEntry parametric_rigid_body_entry() {
  SystemInfo info = parametric_info("M = (Q^-1 P - P^-1 Q) / epsilon - mu Lambda^2, skew");
  info.name = "parametric_rigid_body";
  info.summary = "rigid body in GL(N) with the spectral parameter mu";
  info.equations = "Q' = Q (Omega + mu Lambda), P' = P (Omega + mu Lambda), Omega = J^-1(M)";
  info.source = "[RB] (8.4)-(8.6)";
  info.file = "engine/systems/parametric_rigid_body.h";
  info.methods = methods_on<ParametricRigidBody<double>>(info);
  return {.info = info,
          .check = [](SceneDraft& draft) { check_parametric(draft, 1); },
          .make = make,
          .recommended = recommendations,
          .representation = &representation::parametric_body,
          .motion = &motion_start::parametric_body,
          .example_step = 0.4};
}

}  // namespace stiefel
