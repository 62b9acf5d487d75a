#include <algorithm>

#include "engine/motion/method_entry.h"
#include "engine/motion/methods_on.h"

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

std::optional<MethodOnSystem> declared_by(const MethodEntry& method, const SystemTraits& system,
                                          const SystemInfo& info) {
  if (!method.applies_to || !method.applies_to(system)) return std::nullopt;
  const auto conservation = [&](std::string_view invariant) {
    if (system.conservation)
      if (const auto by_every_method = system.conservation(invariant)) return *by_every_method;
    return method.conservation(system, invariant);
  };
  return MethodOnSystem{method.traits.name, preservations(info, conservation)};
}

}  // namespace stiefel
