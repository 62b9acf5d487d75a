#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "engine/methods/matrix_system.h"
#include "engine/methods/method.h"
#include "engine/motion/observables.h"

namespace stiefel {

/// Makes Simulations of systems whose states are matrices of any size. A null pointer means that
/// the method does not move such systems.
struct MatrixMethod {
  template <class System>
  using Make = std::unique_ptr<Simulation> (*)(const Scene&, const System&,
                                               const SharedObservables&);
  Make<MatrixSystem<double>> by_field = nullptr;      ///< uses the vector field alone
  Make<MatrixLieSystem<double>> by_action = nullptr;  ///< uses the action of a group
};

/// A method in the catalogue. `applies_to` and `conservation` are null for a method that has maps
/// of single systems alone.
struct MethodEntry {
  MethodTraits traits;
  bool (*applies_to)(const SystemTraits&) = nullptr;
  Conservation (*conservation)(const SystemTraits&, std::string_view invariant) = nullptr;
  MatrixMethod matrices = {};
};

/// Returns the methods of methods.inc, in its order.
const std::vector<MethodEntry>& method_entries();
/// Returns null if there is none of that name.
const MethodEntry* method_entry(std::string_view name);

}  // namespace stiefel
