#include "engine/motion/resolve.h"

#include "engine/motion/scene_resolver.h"
#include "engine/motion/system_entry.h"

namespace stiefel {

std::expected<Scene, Violations> Scene::resolve(SceneDescription description, double largest_repair,
                                                const Place& place) {
  if (!description.members)
    return SceneResolver(std::move(description), largest_repair, place).resolve();
  auto ensemble = resolve_members(description, largest_repair, place);
  if (ensemble) ensemble->description_ = std::move(description);
  return ensemble;
}

std::expected<Scene, Violations> Scene::with(MethodDescription method, const Place& place) const {
  const bool narrower = method.scalar == "float" && !in_float();
  if (members().empty() && !narrower) return SceneResolver(*this, place).with(std::move(method));
  SceneDescription changed = description_;
  changed.method = std::move(method);
  return resolve(std::move(changed), drift_tolerance, place);
}

std::expected<Scene, Violations> resolve_recommending(SceneDescription description,
                                                      double largest_repair, const Place& place) {
  if (!lacks_method(description) || description.tolerance)
    return Scene::resolve(std::move(description), largest_repair, place);
  if (!description.members)
    return SceneResolver(std::move(description), largest_repair, place).resolve_recommending();
  auto method = recommended_for_members(description, largest_repair, place);
  if (!method) return std::unexpected(std::move(method.error()));
  description.method = *std::move(method);
  return Scene::resolve(std::move(description), largest_repair, place);
}

bool lacks_method(const SceneDescription& description) {
  const SystemEntry* entry = system_entry(description.system);
  return !description.method && entry != nullptr && !entry->info.discrete;
}

bool wants_choice(const SceneDescription& description) {
  return description.tolerance && lacks_method(description);
}

Violations check_before_choice(const SceneDescription& description, double largest_repair,
                               const Place& place) {
  if (description.members) return check_members_before_choice(description, largest_repair, place);
  SceneResolver resolver(description, largest_repair, place);
  resolver.check();
  return resolver.violations();
}

Violation method_not_chosen(const SceneDescription& description, const Place& place) {
  Violation out =
      place.violation("method", "absent",
                      description.tolerance
                          ? "must be chosen for the tolerance first (resolve_choosing)"
                          : "must be given; resolve_recommending fills in the recommended method");
  out.reason = "METHOD_NOT_CHOSEN";
  return out;
}

}  // namespace stiefel
