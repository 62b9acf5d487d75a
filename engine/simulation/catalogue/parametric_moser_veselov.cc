#include "engine/maps/parametric_moser_veselov.h"

#include "engine/simulation/catalogue/families/parametric_forms.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/scene/scene_draft.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"

namespace stiefel {
namespace {

using Map = ParametricMoserVeselov<double>;

std::unique_ptr<Simulation> make(const Scene& scene) {
  return make_discrete_simulation(
      scene, Map(scene.inertia(), scene.step(), scene.parameter(), scene.epsilon()),
      shared(parametric_observables(scene, scene.step())), 2 * rigid_body_cost(scene.dimension()));
}

}  // namespace

SystemEntry parametric_moser_veselov_entry() {
  SystemInfo info = parametric_info("M = (Q^-1 P - P^-1 Q) / epsilon - mu Lambda^2 / h, skew");
  info.name = "parametric_moser_veselov";
  info.summary = "discrete rigid body in GL(N) with the spectral parameter mu";
  info.equations =
      "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k (U + mu Lambda), P_{k+1} = P_k (U + mu Lambda)";
  info.source = "[RB] (8.10)-(8.11)";
  info.file = "engine/maps/parametric_moser_veselov.h";
  info.discrete = true;
  info.methods = keeps_all(info);
  return {.info = info,
          .check = [](SceneDraft& draft) { check_parametric(draft, draft.step()); },
          .make = make,
          .representation = &representation::discrete_parametric_body};
}

}  // namespace stiefel
