#include "engine/motion/resolve.h"

#include <cmath>

#include "engine/motion/recommendation.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/near_name.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {
namespace {

/// Step indices up to this one are doubles.
constexpr double most_steps = 0x1p53;

/// A tolerance needs a horizon, and takes the place of a method.
void check_tolerance_and_horizon(SceneDraft& draft, const SystemInfo& system) {
  const auto &tolerance = draft.given().tolerance, &horizon = draft.given().horizon;
  if (horizon && !(std::isfinite(*horizon) && *horizon > 0))
    draft.refuse("horizon", to_text(*horizon), "must be finite and > 0");
  else if (horizon && draft.step() != 0 && *horizon > most_steps * std::abs(draft.step()))
    draft.refuse("horizon", to_text(*horizon), "must be at most 2^53 steps");
  if (tolerance && !(*tolerance >= Scene::least_tolerance && *tolerance <= 1))
    draft.refuse("tolerance", to_text(*tolerance),
                 "must be " + to_text(Scene::least_tolerance) + " to 1");
  if (tolerance && !horizon)
    draft.refuse("horizon", "absent",
                 "must be given with `tolerance`: the time up to which it holds");
  if (tolerance && system.discrete)
    draft.refuse("tolerance", to_text(*tolerance),
                 std::string(system.name) + " is a discrete system: there is no method to choose");
  else if (tolerance && draft.given().method)
    draft.refuse("tolerance", to_text(*tolerance),
                 "must be absent when `method` is given: it is for choosing one");
}

void check_method_if_given(SceneDraft& draft, const SystemInfo& system) {
  const auto& method = draft.given().method;
  if (!method) return;
  if (system.discrete)
    draft.refuse("method", '"' + method->name + '"',
                 std::string(system.name) + " is a discrete system and takes no method");
  else
    check_method(draft, system);
}

}  // namespace

void check_scene(SceneDraft& draft) {
  const std::string& name = draft.given().system;
  if (const SystemEntry* entry = system_entry(name); entry == nullptr) {
    draft.refuse("system", name.empty() ? "absent" : '"' + name + '"',
                 "must be one of " + listed(catalogue().systems, &SystemInfo::name) +
                     did_you_mean(name, catalogue().systems, &SystemInfo::name));
  } else {
    draft.set_system(entry->info);
    check_tolerance_and_horizon(draft, entry->info);
    check_method_if_given(draft, entry->info);
    entry->check(draft);
    check_method_accepts_scene(draft, entry->info);
  }
  draft.check_step();
}

std::expected<Scene, Violations> Scene::resolve(SceneDescription description, double largest_repair,
                                                const Place& place) {
  if (description.members) {
    auto ensemble = resolve_members(description, largest_repair, place);
    if (ensemble) ensemble->description_ = std::move(description);
    return ensemble;
  }
  SceneDraft draft(std::move(description), largest_repair, place);
  check_scene(draft);
  if (draft.sound() && lacks_method(draft.given()))
    draft.refuse(method_not_chosen(draft.given(), place));
  return draft.take();
}

std::expected<Scene, Violations> Scene::with(MethodDescription method, const Place& place) const {
  const bool narrower = method.scalar == "float" && !in_float();
  if (!members().empty() || narrower) {
    SceneDescription changed = description_;
    changed.method = std::move(method);
    return resolve(std::move(changed), drift_tolerance, place);
  }
  const SystemInfo& info = system_entry(system())->info;
  SceneDraft draft(*this, place);
  draft.set_system(info);
  draft.given().method = std::move(method);
  check_tolerance_and_horizon(draft, info);
  check_method_if_given(draft, info);
  check_method_accepts_scene(draft, info);
  return draft.take();
}

std::expected<Scene, Violations> resolve_recommending(SceneDescription description,
                                                      double largest_repair, const Place& place) {
  if (!lacks_method(description) || description.tolerance)
    return Scene::resolve(std::move(description), largest_repair, place);
  if (description.members) {
    auto method = recommended_for_members(description, largest_repair, place);
    if (!method) return std::unexpected(std::move(method.error()));
    description.method = *std::move(method);
    return Scene::resolve(std::move(description), largest_repair, place);
  }
  SceneDraft draft(std::move(description), largest_repair, place);
  check_scene(draft);
  if (!draft.sound()) return draft.take();
  std::vector<Recommendation> left = recommended(draft.given().system);
  std::erase_if(left, &Recommendation::members_only);
  keep_what_takes(draft.scene(), left);
  const Recommendation& one = left.front();
  draft.given().method = one.description();
  check_method(draft, system_entry(draft.given().system)->info);
  draft.given().method->substeps = one.substeps(draft.scene());
  return draft.take();
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
  SceneDraft draft(description, largest_repair, place);
  check_scene(draft);
  return draft.violations();
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
