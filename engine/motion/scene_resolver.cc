#include "engine/motion/scene_resolver.h"

#include <cmath>

#include "engine/motion/recommendation.h"
#include "engine/motion/resolve.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/near_name.h"

namespace stiefel {
namespace {

/// Step indices up to this one are doubles.
constexpr double most_steps = 0x1p53;

}  // namespace

void SceneResolver::check() {
  const std::string& name = draft_.given().system;
  if (const SystemEntry* entry = system_entry(name); entry == nullptr) {
    draft_.refuse("system", name.empty() ? "absent" : '"' + name + '"',
                  "must be one of " + listed(catalogue().systems, &SystemInfo::name) +
                      did_you_mean(name, catalogue().systems, &SystemInfo::name));
  } else {
    draft_.set_system(entry->info);
    check_tolerance_and_horizon(entry->info);
    check_method_if_given(entry->info);
    entry->check(draft_);
    check_method_accepts_scene(draft_, entry->info);
  }
  draft_.check_step();
}

std::expected<Scene, Violations> SceneResolver::resolve() {
  check();
  if (draft_.sound() && lacks_method(draft_.given()))
    draft_.refuse(method_not_chosen(draft_.given(), place_));
  return draft_.take();
}

std::expected<Scene, Violations> SceneResolver::resolve_recommending() {
  check();
  if (!draft_.sound()) return draft_.take();
  Recommender recommender(draft_.given().system, Recommender::Scenes::one);
  recommender.take(draft_.scene());
  const Recommendation one = recommender.chosen();
  draft_.given().method = one.description();
  check_method(draft_, system_entry(draft_.given().system)->info);
  draft_.given().method->substeps = one.substeps(draft_.scene());
  return draft_.take();
}

std::expected<Scene, Violations> SceneResolver::with(MethodDescription method) {
  const SystemInfo& system = system_entry(draft_.given().system)->info;
  draft_.set_system(system);
  draft_.given().method = std::move(method);
  check_tolerance_and_horizon(system);
  check_method_if_given(system);
  check_method_accepts_scene(draft_, system);
  return draft_.take();
}

/// A tolerance needs a horizon, and takes the place of a method.
void SceneResolver::check_tolerance_and_horizon(const SystemInfo& system) {
  const auto &tolerance = draft_.given().tolerance, &horizon = draft_.given().horizon;
  if (horizon && !(std::isfinite(*horizon) && *horizon > 0))
    draft_.refuse("horizon", to_text(*horizon), "must be finite and > 0");
  else if (horizon && draft_.step() != 0 && *horizon > most_steps * std::abs(draft_.step()))
    draft_.refuse("horizon", to_text(*horizon), "must be at most 2^53 steps");
  if (tolerance && !(*tolerance >= Scene::least_tolerance && *tolerance <= 1))
    draft_.refuse("tolerance", to_text(*tolerance),
                  "must be " + to_text(Scene::least_tolerance) + " to 1");
  if (tolerance && !horizon)
    draft_.refuse("horizon", "absent",
                  "must be given with `tolerance`: the time up to which it holds");
  if (tolerance && system.discrete)
    draft_.refuse("tolerance", to_text(*tolerance),
                  std::string(system.name) + " is a discrete system: there is no method to choose");
  else if (tolerance && draft_.given().method)
    draft_.refuse("tolerance", to_text(*tolerance),
                  "must be absent when `method` is given: it is for choosing one");
}

void SceneResolver::check_method_if_given(const SystemInfo& system) {
  const auto& method = draft_.given().method;
  if (!method) return;
  if (system.discrete)
    draft_.refuse("method", '"' + method->name + '"',
                  std::string(system.name) + " is a discrete system and takes no method");
  else
    check_method(draft_, system);
}

}  // namespace stiefel
