#pragma once

#include <memory>

#include "engine/methods/support/method.h"
#include "engine/stepping/simulation_of.h"

namespace stiefel {

/// What a Simulation iterates for a Map of a method: `Map::Moved`, a base class that several systems
/// share, or the Map itself.
template <class Map>
struct MovedOf {
  using type = Map;
};
template <class Map>
requires requires { typename Map::Moved; }
struct MovedOf<Map> {
  using type = typename Map::Moved;
};

/// Returns the simulation of `system` by Method, as the scene chooses it. `cost` is a rough number
/// of nanoseconds for a step.
template <class Method, class S>
std::unique_ptr<Simulation> make_simulation_by(const Scene& scene, const S& system,
                                               const SharedObservables& observables, double cost) {
  using Map = typename Method::template Map<S>;
  using Moved = typename MovedOf<Map>::type;
  if constexpr (DirectMap<Moved>) cost *= 10;  // a closed form is computed in extended precision
  const MethodOptions options(scene.order(), scene.arithmetic(), scene.tolerance());
  const auto of = [system, h = scene.step() / scene.substeps(), options](double t) -> Moved {
    return Map(system, static_cast<typename S::Scalar>(t * h), options);
  };
  using Made = SimulationOf<Moved>;
  const bool searched = Method::traits.iterates && scene.substeps() > 1;
  return std::make_unique<Made>(scene, of(1), observables, cost,
                                searched ? typename Made::Make(of) : nullptr);
}

}  // namespace stiefel
