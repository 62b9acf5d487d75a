#include "engine/simulation/catalogue/coordinates/stiefel_in_float.h"

#include "engine/methods/special/stiefel.h"
#include "engine/simulation/catalogue/families/stiefel_forms.h"
#include "engine/simulation/stepping/make_simulation.h"

namespace stiefel {

std::unique_ptr<Simulation> stiefel_in_float(const Scene& scene,
                                             const SharedObservables& observables) {
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  return make_simulation(scene, Stiefel<float>(rounded_to<float>(scene.inertia()), n), observables,
                         stiefel_cost(n, N));
}

}  // namespace stiefel
