#pragma once

#include "engine/motion/make_simulation_by.h"
#include "engine/motion/method_entry.h"

namespace stiefel {

/// Returns the simulation of a system with matrices as states by a method that is general; null if
/// the method is not, or needs a group that the system does not have.
template <HasMatrixStates S>
std::unique_ptr<Simulation> make_matrix_simulation(const MethodEntry& method, const Scene& scene,
                                                   const S& system,
                                                   const SharedObservables& observables) {
  const MatrixMethod& matrices = method.matrices;
  if (matrices.by_field) return matrices.by_field(scene, system, observables);
  if constexpr (LieSystem<S>)
    if (matrices.by_action) return matrices.by_action(scene, system, observables);
  return nullptr;
}

/// Returns the simulation of `system` by the scene's method; null if the method does not apply.
template <HasMatrixStates S>
std::unique_ptr<Simulation> make_simulation(const Scene& scene, const S& system,
                                            const SharedObservables& observables) {
  std::unique_ptr<Simulation> made;
  for_each_type(typename SpecialMethods<S>::type{}, [&]<class Method>(Method*) {
    if (scene.method() == Method::traits.name)
      made = make_simulation_by<Method>(scene, system, observables);
  });
  if (made) return made;
  const MethodEntry* method = method_entry(scene.method());
  return method ? make_matrix_simulation(*method, scene, system, observables) : nullptr;
}

/// Returns the simulation of a discrete system, which is a map already.
template <class Map>
std::unique_ptr<Simulation> make_discrete_simulation(const Scene& scene, Map map,
                                                     const SharedObservables& observables) {
  return std::make_unique<SimulationOf<Map>>(scene, std::move(map), observables);
}

}  // namespace stiefel
