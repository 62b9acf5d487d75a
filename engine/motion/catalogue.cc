#include "stiefel/catalogue.h"

#include <algorithm>
#include <functional>

#include "engine/motion/method_entry.h"
#include "engine/motion/system_entry.h"
#include "engine/motion/tangent_map.h"
#include "engine/motion/two_form.h"

namespace stiefel {

#define SYSTEM(name) SystemEntry name##_entry();
#include "engine/motion/systems.inc"
#undef SYSTEM

namespace {

MethodInfo info_of(const MethodTraits& t) {
  std::vector<int> orders;
  for (const int order : t.orders)
    if (order > 0) orders.push_back(order);
  return {t.name, t.summary,       t.source,     t.file,
          orders, t.default_order, t.reversible, t.default_tolerance};
}

SystemEntry complete(SystemEntry entry) {
  entry.info.methods = entry.methods(entry.info);
  for (MethodOnSystem& on : entry.info.methods) {
    on.in_float = entry.in_float && method_entry(on.method)->traits.in_float;
    if (entry.tangents)
      on.has_tangent =
          std::ranges::count(entry.tangents->methods, on.method, &MethodTangent::method) > 0;
  }
  for (const TwoForm* form : entry.two_forms) entry.info.forms.push_back(form->info);
  return entry;
}

/// Returns null if there is none of that name.
template <class T, class Name>
const T* find(const std::vector<T>& all, std::string_view name, Name name_of) {
  const auto found = std::ranges::find(
      all, name, [&](const T& x) { return std::string_view(std::invoke(name_of, x)); });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

const std::vector<SystemEntry>& system_entries() {
  static const std::vector<SystemEntry> all = {
#define SYSTEM(name) complete(name##_entry()),
#include "engine/motion/systems.inc"
#undef SYSTEM
  };
  return all;
}

const SystemEntry* system_entry(std::string_view name) {
  return find(system_entries(), name, [](const SystemEntry& e) { return e.info.name; });
}

const Catalogue& catalogue() {
  static const Catalogue built = [] {
    Catalogue c;
    for (const SystemEntry& entry : system_entries()) c.systems.push_back(entry.info);
    for (const MethodEntry& method : method_entries()) c.methods.push_back(info_of(method.traits));
    return c;
  }();
  return built;
}

const SystemInfo* Catalogue::system(std::string_view name) const {
  return find(systems, name, &SystemInfo::name);
}
const MethodInfo* Catalogue::method(std::string_view name) const {
  return find(methods, name, &MethodInfo::name);
}

std::string_view to_string(Conservation conservation) {
  switch (conservation) {
    case Conservation::exact:
      return "exact";
    case Conservation::bounded:
      return "bounded";
    case Conservation::drifts:
      return "drifts";
  }
  return "";
}

}  // namespace stiefel
