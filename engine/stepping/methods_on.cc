#include "engine/stepping/methods_on.h"

namespace stiefel {

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

void offer_in_float(SystemInfo& info) {
  for (MethodOnSystem& on : info.methods) on.in_float = method_entry(on.method)->traits.in_float;
}

}  // namespace stiefel
