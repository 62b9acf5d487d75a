#pragma once

#include "engine/simulation/stepping/make_map.h"
#include "engine/simulation/stepping/matrix_simulation.h"
#include "engine/simulation/stepping/methods.h"
#include "stiefel/catalogue.h"

namespace stiefel {

/// Returns the simulation of `system` by Method.
template <class Method, class S, class Observables>
std::unique_ptr<Simulation> simulate_by(const Scene& scene, const S& system,
                                        const Observables& observables, double cost) {
  using Scalar = typename S::Scalar;
  if constexpr (by_field_alone<Method, S>)
    return simulate_matrices(scene, MatrixSystem<Scalar>(system),
                             MatrixObservables<Scalar>(observables), cost);
  else if constexpr (by_action_alone<Method, S>)
    return simulate_matrices(scene, MatrixLieSystem<Scalar>(system),
                             MatrixObservables<Scalar>(observables), cost);
  else
    return make_map<Method>(scene, system, observables, cost);
}

/// Returns the simulation of `system` by the scene's method if it is one of Among; else null.
/// `cost` is a rough number of nanoseconds for a step.
template <class Among = Methods, class S, class Observables>
std::unique_ptr<Simulation> simulate(const Scene& scene, const S& system,
                                     const Observables& observables, double cost) {
  std::unique_ptr<Simulation> made;
  const auto attempt = [&]<class Method>(Method*) {
    if constexpr (Method::template applies<S>)
      if (scene.method() == Method::traits.name)
        made = simulate_by<Method>(scene, system, observables, cost);
  };
  for_each_type(Among{}, attempt);
  return made;
}

/// Returns the simulation of a discrete system, which is a map already.
template <class Map, class Observables>
std::unique_ptr<Simulation> simulate_map(const Scene& scene, Map map,
                                         const Observables& observables, double cost) {
  return std::make_unique<SimulationOf<Map, Observables>>(scene, std::move(map), observables, cost);
}

/// Returns the result of `conservation` for each invariant of a system.
template <class ConservationOf>
std::vector<Preservation> preservations(const SystemInfo& info, ConservationOf conservation) {
  std::vector<Preservation> all;
  for (const auto& invariant : info.invariants)
    all.push_back({invariant.name, conservation(invariant.name)});
  return all;
}

/// Returns the declarations of a discrete system that keeps all its invariants.
inline std::vector<MethodOnSystem> keeps_all(const SystemInfo& info) {
  return {{"", preservations(info, [](auto) { return Conservation::exact; })}};
}

/// Returns the Conservation of an invariant of S by Method: what S declares if it does, else what
/// Method declares for all systems.
template <class Method, class S>
Conservation conservation_by(std::string_view invariant) {
  if constexpr (requires { S::conservation(invariant); })
    if (const auto conservation = S::conservation(invariant)) return *conservation;
  return Method::template conservation<S>(invariant);
}

/// Returns the methods that apply to S and what they do to the invariants that `info` lists.
/// Includes, for N = 3 only, methods that apply to `InThree`, the form of the system in three
/// dimensions, but not to S.
template <class S, class InThree = S>
std::vector<MethodOnSystem> methods_on(const SystemInfo& info) {
  std::vector<MethodOnSystem> all;
  const auto attempt = [&]<class Method>(Method*) {
    constexpr bool any = Method::template applies<S>;
    if constexpr (any || Method::template applies<InThree>) {
      using Form = std::conditional_t<any, S, InThree>;
      MethodOnSystem on{Method::traits.name, preservations(info, conservation_by<Method, Form>)};
      if constexpr (!any) {
        on.where = "N = 3";
        on.takes = [](const Eigen::VectorXd& lambda) { return lambda.size() == 3; };
      } else if constexpr (requires { Method::template MotionOf<Form>::where; }) {
        on.where = Method::template MotionOf<Form>::where;
        on.takes = Method::template takes<Form>;
      }
      all.push_back(std::move(on));
    }
  };
  for_each_type(Methods{}, attempt);
  return all;
}

}  // namespace stiefel
