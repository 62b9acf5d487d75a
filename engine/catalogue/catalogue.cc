#include "stiefel/catalogue.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <stdexcept>
#include <utility>

#include "engine/rigid_body/two_forms.h"
#include "engine/catalogue/methods/method_traits.h"
#include "engine/catalogue/system_entry.h"
#include "engine/stepping/method_entry.h"

namespace stiefel {

#define SYSTEM(name) SystemEntry name##_entry();
#include "engine/catalogue/systems.inc"
#undef SYSTEM

namespace {

MethodInfo info_of(const MethodTraits& t) {
  std::vector<int> orders;
  for (const int order : t.orders)
    if (order > 0) orders.push_back(order);
  return {t.name, t.summary,       t.source,     t.file,
          orders, t.default_order, t.reversible, t.default_tolerance};
}

struct Listed {
  std::vector<SystemEntry> systems;
  std::vector<MethodTraits> methods;
};

/// Whether the catalogue has been read.
std::atomic<bool> in_use = false;

Listed& listed() {
  static Listed all = [] {
    Listed made;
#define SYSTEM(name) made.systems.push_back(name##_entry());
#include "engine/catalogue/systems.inc"
#undef SYSTEM
    for (const MethodEntry& method : method_entries()) made.methods.push_back(method.traits);
    return made;
  }();
  return all;
}

const Listed& seen() {
  in_use.store(true, std::memory_order_relaxed);
  return listed();
}

Listed& open_for(std::string_view name) {
  if (in_use)
    throw std::logic_error("the catalogue is in use: " + std::string(name) + " comes too late");
  return listed();
}

[[noreturn]] void refuse_double(std::string_view name) {
  throw std::logic_error("the catalogue has " + std::string(name) + " already");
}

/// Returns null if there is none of that name.
template <class T, class Name>
const T* find(const std::vector<T>& all, std::string_view name, Name name_of) {
  const auto found = std::ranges::find(
      all, name, [&](const T& x) { return std::string_view(std::invoke(name_of, x)); });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

const std::vector<SystemEntry>& system_entries() { return seen().systems; }

const SystemEntry* system_entry(std::string_view name) {
  return find(system_entries(), name, [](const SystemEntry& e) { return e.info.name; });
}

const MethodTraits* method_traits(std::string_view name) {
  return find(seen().methods, name, [](const MethodTraits& t) { return t.name; });
}

void register_system(SystemEntry entry) {
  auto& all = open_for(entry.info.name).systems;
  if (find(all, entry.info.name, [](const SystemEntry& e) { return e.info.name; }))
    refuse_double(entry.info.name);
  all.push_back(std::move(entry));
}

void register_method(const MethodTraits& traits) {
  auto& all = open_for(traits.name).methods;
  if (find(all, traits.name, [](const MethodTraits& t) { return t.name; }))
    refuse_double(traits.name);
  all.push_back(traits);
}

const Catalogue& catalogue() {
  static const Catalogue built = [] {
    Catalogue c;
    for (const SystemEntry& entry : system_entries()) {
      c.systems.push_back(entry.info);
      for (const TwoForm* form : entry.two_forms) c.systems.back().forms.push_back(form->info);
    }
    for (const MethodTraits& traits : seen().methods) c.methods.push_back(info_of(traits));
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
