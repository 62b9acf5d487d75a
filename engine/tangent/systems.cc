#include "engine/tangent/systems.h"

#include <map>

namespace stiefel {

#define SYSTEM(name) Tangents name##_tangents();
#include "engine/catalogue/systems.inc"
#undef SYSTEM

std::optional<Tangents> tangents_of(std::string_view system) {
  static const std::map<std::string_view, Tangents> all = {
#define SYSTEM(name) {#name, name##_tangents()},
#include "engine/catalogue/systems.inc"
#undef SYSTEM
  };
  const auto found = all.find(system);
  return found == all.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace stiefel
