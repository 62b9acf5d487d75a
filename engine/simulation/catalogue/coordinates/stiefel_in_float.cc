#include "engine/simulation/catalogue/coordinates/in_float.h"
#include "engine/simulation/catalogue/families/stiefel_forms.h"
#include "engine/simulation/stepping/simulate.h"
#include "engine/simulation/stepping/stored_as.h"
#include "engine/systems/stiefel.h"

namespace stiefel {

std::unique_ptr<Simulation> stiefel_in_float(const Scene& scene,
                                             const StackedObservables& observables) {
  using Stored = StoredAs<SinglePrecision<StackedObservables::Point>, StackedObservables>;
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  return simulate<MethodsInFloat>(scene, Stiefel<float>(rounded_to<float>(scene.inertia()), n),
                                  Stored(observables), stiefel_cost(n, N));
}

}  // namespace stiefel
