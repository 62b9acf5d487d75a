#pragma once

#include "engine/methods/special_methods.h"
#include "engine/motion/method_entry.h"
#include "engine/motion/simulation_of.h"

namespace stiefel {

/// Returns the simulation that a method makes of its maps of(h, options), as the scene chooses
/// them; of a discrete system by the method's default order.
template <class MapOfStep>
std::unique_ptr<Simulation> simulation_by(const MethodTraits& method, const Scene& scene,
                                          const SharedObservables& observables, MapOfStep of) {
  const MethodOptions options(scene.order() > 0 ? scene.order() : method.default_order,
                              scene.arithmetic(), scene.tolerance());
  const auto of_length = [of, options, h = scene.step() / scene.substeps()](double t) {
    return of(t * h, options);
  };
  using Moved = SimulationOf<decltype(of_length(1))>;
  const bool searched = method.iterates && scene.substeps() > 1;
  return std::make_unique<Moved>(scene, of_length(1), observables,
                                 searched ? typename Moved::Make(of_length) : nullptr);
}

/// Returns the simulation of `system` by Method, as the scene chooses it.
template <class Method, class S>
std::unique_ptr<Simulation> make_simulation_by(const Scene& scene, const S& system,
                                               const SharedObservables& observables) {
  return simulation_by(
      Method::traits, scene, observables, [system](double h, const MethodOptions& options) {
        return map_of(Method(), system, static_cast<typename S::Scalar>(h), options);
      });
}

/// Returns the entry of Method in the catalogue.
template <class Method>
MethodEntry method_entry_of() {
  MethodEntry entry{Method::traits, Method::conservation};
  if constexpr (GeneralMethod<Method>) {
    entry.applies_to = Method::applies_to;
    entry.by_field = !std::derived_from<Method, LieMethod>;
    entry.make = [](const Scene& scene, const MatrixSystem<double>& system,
                    const SharedObservables& observables) {
      return simulation_by(
          Method::traits, scene, observables, [system](double h, const MethodOptions& options) {
            return typename Method::template Map<MatrixSystem<double>>(system, h, options);
          });
    };
  }
  return entry;
}

/// Calls visit(static_cast<Method*>(nullptr)) with the method of this name, if it has a map of S
/// alone.
template <class S, class Visit>
void with_special_method(std::string_view name, const Visit& visit) {
  for_each_type(SpecialMethods{}, [&]<class Method>(Method* method) {
    if constexpr (applies<Method, S>)
      if (name == Method::traits.name) visit(method);
  });
}

/// Returns the simulation of a system with matrices as states by the scene's method; null if the
/// method does not apply.
template <HasMatrixStates S>
std::unique_ptr<Simulation> make_simulation(const Scene& scene, const S& system,
                                            const SharedObservables& observables) {
  const MethodEntry* method = method_entry(scene.method());
  if (method && method->applies_to && method->applies_to(system_traits<S>))
    return method->make(scene, system, observables);
  std::unique_ptr<Simulation> made;
  with_special_method<S>(scene.method(), [&]<class Method>(Method*) {
    made = make_simulation_by<Method>(scene, system, observables);
  });
  return made;
}

/// Returns the methods that apply to S and what they do to the invariants that `info` lists, in the
/// order of the catalogue.
template <class S>
std::vector<MethodOnSystem> methods_on(const SystemInfo& info) {
  std::vector<MethodOnSystem> all;
  const SystemTraits& traits = system_traits<S>;
  for (const MethodEntry& method : method_entries()) {
    if (method.applies_to && method.applies_to(traits))
      all.push_back(declared_by(method, traits, {}, info));
    with_special_method<S>(method.traits.name, [&]<class Method>(Method*) {
      all.push_back(declared_by(method, traits, declared<Method, S>, info));
    });
  }
  return all;
}

}  // namespace stiefel
