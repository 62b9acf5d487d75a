#pragma once

#include "engine/motion/make_simulation_by.h"
#include "engine/motion/method_entry.h"

namespace stiefel {

/// Returns what Method offers to systems whose states are matrices of any size.
template <GeneralMethod Method>
MatrixMethod matrix_method() {
  using ByField = MatrixSystem<double>;
  using ByAction = MatrixLieSystem<double>;
  MatrixMethod made;
  if constexpr (requires { typename Method::template Map<ByField>; })
    made.by_field = make_simulation_by<Method, ByField>;
  else if constexpr (requires { typename Method::template Map<ByAction>; })
    made.by_action = make_simulation_by<Method, ByAction>;
  return made;
}

/// Returns the entry of Method in the catalogue.
template <class Method>
MethodEntry method_entry_of() {
  MethodEntry entry;
  entry.traits = Method::traits;
  if constexpr (GeneralMethod<Method>) {
    entry.applies_to = Method::applies_to;
    entry.conservation = Method::conservation;
    entry.matrices = matrix_method<Method>();
  }
  return entry;
}

}  // namespace stiefel
