#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "engine/methods/method.h"
#include "engine/motion/observables.h"
#include "stiefel/catalogue.h"

namespace stiefel {

/// A method in the catalogue.
struct MethodEntry {
  /// Makes the simulation of a system with matrices as states.
  using Make = std::unique_ptr<Simulation> (*)(const Scene&, const MatrixSystem<double>&,
                                               const SharedObservables&);
  MethodTraits traits;
  Conservation (*conservation)(const SystemTraits&, std::string_view invariant);
  // Of a general method:
  bool (*applies_to)(const SystemTraits&) = nullptr;
  Make make = nullptr;
  bool by_field = false;  ///< sums the vector field, and does not move a state by a group
};

/// Returns the methods of methods.inc, in its order.
const std::vector<MethodEntry>& method_entries();
/// Returns null if there is none of that name.
const MethodEntry* method_entry(std::string_view name);

/// Returns what a method does to the invariants that `info` lists: what the system declares of
/// every method if it does, else what the method declares of this system, or of all.
MethodOnSystem declared_by(const MethodEntry& method, const SystemTraits& system,
                           const Declared& declared, const SystemInfo& info);

/// Returns the declarations of a discrete system that keeps all its invariants.
std::vector<MethodOnSystem> keeps_all(const SystemInfo& info);

}  // namespace stiefel
