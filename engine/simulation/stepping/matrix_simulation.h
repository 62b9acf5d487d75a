#pragma once

#include <memory>

#include "engine/simulation/stepping/matrix_observables.h"
#include "engine/systems/matrix_system.h"

namespace stiefel {

/// Whether Method needs no more of S, whose states are matrices, than its vector field; or than its
/// group's action. Then it is compiled once for all such systems.
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

/// A system in the hands of the scene's method, if that is one which needs its vector field alone;
/// else null. `cost`: nanoseconds of a step, roughly.
template <class Scalar>
std::unique_ptr<Simulation> simulate_matrices(const Scene& scene,
                                              const MatrixSystem<Scalar>& system,
                                              const MatrixObservables<Scalar>& observables,
                                              double cost);
/// If it is one which needs its group's action alone.
template <class Scalar>
std::unique_ptr<Simulation> simulate_matrices(const Scene& scene,
                                              const MatrixLieSystem<Scalar>& system,
                                              const MatrixObservables<Scalar>& observables,
                                              double cost);

}  // namespace stiefel
