#include "stiefel/catalogue.h"

#include <algorithm>

#include "engine/simulation/catalogue/methods.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/diagnosis/structure.h"
#include "engine/simulation/run/ensemble.h"

namespace stiefel {
namespace {

MethodInfo info_of(const MethodTraits& t) {
  std::vector<int> orders;
  for (const int order : t.orders)
    if (order > 0) orders.push_back(order);
  return {t.name, t.summary,       t.source,     t.file,
          orders, t.default_order, t.reversible, t.default_tolerance};
}

template <class... M>
std::vector<MethodInfo> infos(TypeList<M...>) {
  return {info_of(M::traits)...};
}

template <class Range>
auto find(const Range& range, std::string_view name) -> decltype(&*range.begin()) {
  const auto found = std::ranges::find_if(range, [&](const auto& x) { return x.name == name; });
  return found == range.end() ? nullptr : &*found;
}

}  // namespace

const std::vector<SystemEntry>& system_entries() {
  static const std::vector<SystemEntry> entries = {
      rigid_body_entry(),
      right_rigid_body_entry(),
      symmetric_rigid_body_entry(),
      right_symmetric_rigid_body_entry(),
      reduced_rigid_body_entry(),
      mclachlan_scovel_entry(),
      parametric_rigid_body_entry(),
      stiefel_entry(),
      stiefel_momentum_entry(),
      stiefel_costate_entry(),
      ellipsoid_entry(),
      double_bracket_entry(),
      moser_veselov_entry(),
      moser_veselov_pair_entry(),
      symmetric_moser_veselov_entry(),
      parametric_moser_veselov_entry(),
      discrete_stiefel_entry(),
  };
  return entries;
}

const Catalogue& catalogue() {
  static const Catalogue built = [] {
    Catalogue c;
    for (const auto& entry : system_entries()) {
      c.systems.push_back(entry.info);
      c.systems.back().forms = forms_of(entry.info.name);
    }
    c.methods = infos(Methods{});
    return c;
  }();
  return built;
}

const SystemInfo* Catalogue::system(std::string_view name) const { return find(systems, name); }
const MethodInfo* Catalogue::method(std::string_view name) const { return find(methods, name); }

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

const SystemEntry* system_entry(std::string_view name) {
  const auto& entries = system_entries();
  const auto entry =
      std::ranges::find_if(entries, [&](const SystemEntry& e) { return e.info.name == name; });
  return entry == entries.end() ? nullptr : &*entry;
}

std::unique_ptr<Simulation> make_simulation(const Scene& scene) {
  if (!scene.members().empty()) return std::make_unique<Ensemble>(scene.members());
  return system_entry(scene.system())->make(scene);
}

}  // namespace stiefel
