#include "stiefel/catalogue.h"

#include <algorithm>

#include "engine/motion/method_entry.h"
#include "engine/motion/system_entry.h"
#include "engine/motion/tangent_map.h"
#include "engine/motion/two_form.h"

namespace stiefel {

#define SYSTEM(name) SystemEntry name##_entry();
#include "engine/motion/systems.inc"
#undef SYSTEM
#define METHOD(file, Type) MethodEntry file##_method();
#include "engine/methods/methods.inc"
#undef METHOD

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

const std::vector<MethodEntry>& method_entries() {
  static const std::vector<MethodEntry> all = {
#define METHOD(file, Type) file##_method(),
#include "engine/methods/methods.inc"
#undef METHOD
  };
  return all;
}

const MethodEntry* method_entry(std::string_view name) {
  return find(method_entries(), name, [](const MethodEntry& m) { return m.traits.name; });
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
