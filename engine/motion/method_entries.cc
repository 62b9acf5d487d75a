#include <algorithm>

#include "engine/motion/method_entry.h"

namespace stiefel {

#define METHOD(file, Type) MethodEntry file##_method();
#include "engine/methods/methods.inc"
#undef METHOD

const std::vector<MethodEntry>& method_entries() {
  static const std::vector<MethodEntry> all = {
#define METHOD(file, Type) file##_method(),
#include "engine/methods/methods.inc"
#undef METHOD
  };
  return all;
}

const MethodEntry* method_entry(std::string_view name) {
  const auto& all = method_entries();
  const auto found = std::ranges::find(
      all, name, [](const MethodEntry& m) { return std::string_view(m.traits.name); });
  return found == all.end() ? nullptr : &*found;
}

MethodOnSystem declared_by(const MethodEntry& method, const SystemTraits& system,
                           const Declared& declared, const SystemInfo& info) {
  MethodOnSystem on{method.traits.name, {}, declared.where, declared.takes};
  for (const InvariantInfo& invariant : info.invariants) {
    const auto by_every_method =
        system.conservation ? system.conservation(invariant.name) : std::nullopt;
    on.preserves.push_back({invariant.name, by_every_method ? *by_every_method
                                            : declared.conservation
                                                ? declared.conservation(invariant.name)
                                                : method.conservation(system, invariant.name)});
  }
  return on;
}

std::vector<MethodOnSystem> keeps_all(const SystemInfo& info) {
  MethodOnSystem on{"", {}};
  for (const auto& invariant : info.invariants)
    on.preserves.push_back({invariant.name, Conservation::exact});
  return {on};
}

}  // namespace stiefel
