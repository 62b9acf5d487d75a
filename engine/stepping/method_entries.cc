#include <algorithm>

#include "engine/stepping/method_entry.h"

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

}  // namespace stiefel
