#pragma once

#include <memory>

#include "engine/methods/method.h"
#include "engine/motion/simulation_of.h"

namespace stiefel {

/// What a Simulation iterates for a Map of a method: `Map::Moved`, a base class that several
/// systems share, or the Map itself.
template <class Map>
struct MovedOf {
  using type = Map;
};
template <class Map>
requires requires { typename Map::Moved; }
struct MovedOf<Map> {
  using type = typename Map::Moved;
};

/// Returns the map of a step t·h.
template <class Map>
using MapOfLength = std::function<Map(double t)>;

/// Returns the simulation of the map of(1). If `searched`, the largest step of a step that left the
/// domain is found for all substeps.
template <class Map>
std::unique_ptr<Simulation> simulation_of(const Scene& scene, const MapOfLength<Map>& of,
                                          const SharedObservables& observables, bool searched) {
  return std::make_unique<SimulationOf<Map>>(scene, of(1), observables, searched ? of : nullptr);
}

/// Returns the simulation of `system` by Method, as the scene chooses it, a discrete system by the
/// method's default order.
template <class Method, class S>
std::unique_ptr<Simulation> make_simulation_by(const Scene& scene, const S& system,
                                               const SharedObservables& observables) {
  using Map = typename Method::template Map<S>;
  using Moved = typename MovedOf<Map>::type;
  const int order = scene.order() > 0 ? scene.order() : Method::traits.default_order;
  const MethodOptions options(order, scene.arithmetic(), scene.tolerance());
  const auto of = [system, h = scene.step() / scene.substeps(), options](double t) -> Moved {
    return Map(system, static_cast<typename S::Scalar>(t * h), options);
  };
  return simulation_of<Moved>(scene, of, observables,
                              Method::traits.iterates && scene.substeps() > 1);
}

}  // namespace stiefel
