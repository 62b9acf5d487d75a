#include "engine/rigid_body/parametric/parametric_forms.h"
#include "engine/rigid_body/parametric/parametric_moser_veselov.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

using Map = ParametricMoserVeselov<double>;

std::unique_ptr<Simulation> make_parametric_moser_veselov(const Scene& scene) {
  return make_discrete_simulation(
      scene, Map(scene.inertia(), scene.step(), scene.parameter(), scene.epsilon()),
      shared(parametric_observables(scene, scene.step())));
}

}  // namespace

Simulations parametric_moser_veselov_simulations() {
  return {make_parametric_moser_veselov, keeps_all};
}

}  // namespace stiefel
