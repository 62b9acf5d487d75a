#include "engine/frames/stiefel_in_float.h"

#include "engine/frames/stiefel_maps.h"
#include "engine/stepping/single_precision.h"
#include "engine/frames/stiefel_forms.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/stored_as.h"

namespace stiefel {

std::unique_ptr<Simulation> stiefel_in_float(const Scene& scene,
                                             const StackedObservables& observables) {
  using Stored = StoredAs<SinglePrecision<StackedObservables::Point>, StackedObservables>;
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  return make_simulation(scene, Stiefel<float>(rounded_to<float>(scene.inertia()), n),
                         Stored(observables), stiefel_cost(n, N));
}

}  // namespace stiefel
