#pragma once

#include "engine/motion/method_entry.h"
#include "engine/motion/simulation_of.h"

namespace stiefel {

/// Returns the simulation that a method makes of its maps of(h, options), as the scene chooses
/// them; of a discrete system by the method's default order.
template <class MapOfStep>
[[gnu::cold]] std::unique_ptr<Simulation> simulation_by(const MethodTraits& method,
                                                        const Scene& scene,
                                                        const SharedObservables& observables,
                                                        MapOfStep of) {
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
[[gnu::cold]] std::unique_ptr<Simulation> make_simulation_by(const Scene& scene, const S& system,
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

/// Returns the simulation of a system with matrices as states by the scene's method: a general one,
/// or one of the Special, which have maps of S alone; null if the method does not apply.
template <class... Special, HasMatrixStates S>
std::unique_ptr<Simulation> make_simulation(const Scene& scene, const S& system,
                                            const SharedObservables& observables) {
  const MethodEntry* method = method_entry(scene.method());
  if (method && method->applies_to && method->applies_to(system_traits<S>))
    return method->make(scene, system, observables);
  std::unique_ptr<Simulation> made;
  [[maybe_unused]] const auto make_by = [&]<class Method>(Method) {
    if (scene.method() == Method::traits.name)
      made = make_simulation_by<Method>(scene, system, observables);
  };
  (make_by(Special()), ...);
  return made;
}

/// Returns the methods that apply to S, with those that are Special, and what they do to the
/// invariants that `info` lists, in the order of the catalogue.
template <class S, class... Special>
std::vector<MethodOnSystem> methods_on(const SystemInfo& info) {
  std::vector<MethodOnSystem> all;
  const SystemTraits& traits = system_traits<S>;
  for (const MethodEntry& method : method_entries()) {
    if (method.applies_to && method.applies_to(traits))
      all.push_back(declared_by(method, traits, {}, info));
    [[maybe_unused]] const auto declare = [&]<class Method>(Method) {
      if (std::string_view(method.traits.name) == Method::traits.name)
        all.push_back(declared_by(method, traits, declared<Method, S>, info));
    };
    (declare(Special()), ...);
  }
  return all;
}

}  // namespace stiefel
