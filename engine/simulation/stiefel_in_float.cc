#include "engine/simulation/held_as.h"
#include "engine/simulation/in_float.h"
#include "engine/simulation/simulate.h"
#include "engine/simulation/stiefel_forms.h"
#include "engine/systems/stiefel.h"

namespace stiefel {

std::unique_ptr<Simulation> stiefel_in_float(const Scene& scene, const StackedReadout& readout) {
  using Held = HeldAs<SinglePrecision<StackedReadout::Point>, StackedReadout>;
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  return simulate<MethodsInFloat>(scene, Stiefel<float>(rounded_to<float>(scene.inertia()), n),
                                  Held(readout), stiefel_cost(n, N));
}

}  // namespace stiefel
