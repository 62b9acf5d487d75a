#pragma once

#include <memory>

#include "engine/stepping/simulation_of.h"

namespace stiefel {

/// Returns the simulation of `system` by Method, in the arithmetic of the scene. `cost` is a rough
/// number of nanoseconds for a step.
template <class Method, class S, class Observables>
std::unique_ptr<Simulation> make_simulation_by(const Scene& scene, const S& system,
                                               const Observables& observables, double cost) {
  const double h = scene.step() / scene.substeps();
  const auto make = [&]<class Map>(Map*) -> std::unique_ptr<Simulation> {
    if constexpr (DirectMap<Map>) cost *= 10;  // a closed form is computed in extended precision
    const auto of = [system, h, order = scene.order(), tolerance = scene.tolerance()](double t) {
      const auto step = static_cast<typename S::Scalar>(t * h);
      if constexpr (Method::traits.default_tolerance > 0)
        return Map(system, step, order, tolerance);
      else
        return Map(system, step, order);
    };
    using Made = SimulationOf<Map, Observables>;
    const bool searched = Method::traits.iterates && scene.substeps() > 1;
    return std::make_unique<Made>(scene, of(1), observables, cost,
                                  searched ? typename Made::Make(of) : nullptr);
  };
  if (scene.arithmetic() == Arithmetic::plain)
    return make(static_cast<typename Method::template Map<S, Arithmetic::plain>*>(nullptr));
  return make(static_cast<typename Method::template Map<S, Arithmetic::compensated>*>(nullptr));
}

}  // namespace stiefel
