#pragma once

#include <memory>

#include "engine/simulation/stepping/matrix_observables.h"
#include "engine/systems/matrix_system.h"

namespace stiefel {

/// Whether the states of S are matrices, and Method uses only the vector field of S
/// (`by_field_alone`) or only its group action (`by_action_alone`). Such a method is compiled once
/// for all these systems.
template <class Method, class S>
constexpr bool by_field_alone = [] {
  if constexpr (!HasMatrixStates<S>)
    return false;
  else if constexpr (requires { Method::template by_field_alone<S>; })
    return Method::template by_field_alone<S>;
  else
    return Method::template applies<MatrixSystem<typename S::Scalar>>;
}();
template <class Method, class S>
constexpr bool by_action_alone = [] {
  if constexpr (!HasMatrixStates<S> || !LieSystem<S>)
    return false;
  else
    return Method::template applies<MatrixLieSystem<typename S::Scalar>>;
}();

/// Returns the simulation of `system` by the scene's method if the method uses only the vector
/// field; else null. `cost` is a rough number of nanoseconds for a step.
template <class Scalar>
std::unique_ptr<Simulation> simulate_matrices(const Scene& scene,
                                              const MatrixSystem<Scalar>& system,
                                              const MatrixObservables<Scalar>& observables,
                                              double cost);
/// Returns the simulation of `system` by the scene's method if the method uses only the group
/// action; else null. `cost` is a rough number of nanoseconds for a step.
template <class Scalar>
std::unique_ptr<Simulation> simulate_matrices(const Scene& scene,
                                              const MatrixLieSystem<Scalar>& system,
                                              const MatrixObservables<Scalar>& observables,
                                              double cost);

}  // namespace stiefel
