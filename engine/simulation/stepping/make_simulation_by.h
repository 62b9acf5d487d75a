#pragma once

#include <memory>

#include "engine/simulation/stepping/simulation_of.h"

namespace stiefel {

/// Returns the simulation of `system` by Method, in the arithmetic of the scene. `cost` is a rough
/// number of nanoseconds for a step.
template <class Method, class S, class Observables>
std::unique_ptr<Simulation> make_simulation_by(const Scene& scene, const S& system,
                                               const Observables& observables, double cost) {
  const auto h = static_cast<typename S::Scalar>(scene.step() / scene.substeps());
  const auto make = [&]<class Map>(Map*) -> std::unique_ptr<Simulation> {
    using Made = SimulationOf<Map, Observables>;
    if constexpr (DirectMap<Map>) cost *= 10;  // a closed form is computed in extended precision
    if constexpr (Method::traits.default_tolerance > 0)
      return std::make_unique<Made>(scene, Map(system, h, scene.order(), scene.tolerance()),
                                    observables, cost);
    else
      return std::make_unique<Made>(scene, Map(system, h, scene.order()), observables, cost);
  };
  if (scene.arithmetic() == Arithmetic::plain)
    return make(static_cast<typename Method::template Map<S, Arithmetic::plain>*>(nullptr));
  return make(static_cast<typename Method::template Map<S, Arithmetic::compensated>*>(nullptr));
}

}  // namespace stiefel
