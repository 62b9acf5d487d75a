#include "engine/simulation/catalogue/resolve.h"

#include <algorithm>
#include <cmath>

#include "engine/simulation/catalogue/methods/recommendation.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/scene/near_name.h"
#include "engine/simulation/scene/scene_draft.h"

namespace stiefel {

std::expected<Scene, Violations> Scene::resolve(SceneDescription description, double largest_repair,
                                                const Place& place) {
  if (!description.members)
    return SceneDraft(std::move(description), largest_repair, place).resolve();
  auto ensemble = resolve_members(description, largest_repair, place);
  if (ensemble) ensemble->description_ = std::move(description);
  return ensemble;
}

std::expected<Scene, Violations> Scene::with(MethodDescription method, const Place& place) const {
  const bool narrower = method.scalar == "float" && !in_float();
  if (members().empty() && !narrower) return SceneDraft(*this, place).with(std::move(method));
  SceneDescription changed = description_;
  changed.method = std::move(method);
  changed.tolerance.reset();
  return resolve(std::move(changed), drift_tolerance, place);
}

bool wants_choice(const SceneDescription& description) {
  const SystemEntry* entry = system_entry(description.system);
  return description.tolerance && !description.method && entry != nullptr && !entry->info.discrete;
}

Violations check_before_choice(const SceneDescription& description, double largest_repair,
                               const Place& place) {
  if (description.members) return check_members_before_choice(description, largest_repair, place);
  SceneDraft draft(description, largest_repair, place);
  draft.check();
  return draft.violations();
}

Violation method_not_chosen(const Place& place) {
  Violation out = place.violation("method", "absent",
                                  "must be chosen for the tolerance first (resolve_choosing)");
  out.reason = "METHOD_NOT_CHOSEN";
  return out;
}

void SceneDraft::check() {
  const SystemEntry* entry = system_entry(given().system);
  if (entry == nullptr) {
    refuse("system", '"' + given().system + '"',
           "must be one of " + listed(catalogue().systems, &SystemInfo::name) +
               did_you_mean(given().system, catalogue().systems, &SystemInfo::name));
  } else {
    system_ = &entry->info;
    check_method();
    entry->check(*this);
    check_reach();
  }
  check_step();
}

std::expected<Scene, Violations> SceneDraft::resolve() {
  check();
  if (sound() && wants_choice(given())) violations_.push_back(method_not_chosen(place_));
  if (sound() && !given().method && !system_->discrete) recommend();
  if (!sound()) return std::unexpected(std::move(violations_));
  return std::move(scene_);
}

std::expected<Scene, Violations> SceneDraft::with(MethodDescription method) {
  system_ = &system_entry(given().system)->info;
  given().method = std::move(method);
  given().tolerance.reset();
  check_method();
  check_reach();
  if (!sound()) return std::unexpected(std::move(violations_));
  return std::move(scene_);
}

/// Checks tolerance and horizon. A tolerance replaces a method.
void SceneDraft::check_choice() {
  const auto &tolerance = given().tolerance, &horizon = given().horizon;
  if (horizon && !(std::isfinite(*horizon) && *horizon > 0))
    refuse("horizon", to_text(*horizon), "must be finite and > 0");
  if (tolerance && !(*tolerance >= Scene::least_tolerance && *tolerance <= 1))
    refuse("tolerance", to_text(*tolerance),
           "must be " + to_text(Scene::least_tolerance) + " to 1");
  if (tolerance && !horizon)
    refuse("horizon", "absent", "must be given with `tolerance`: the time up to which it holds");
  if (tolerance && system_->discrete)
    refuse("tolerance", to_text(*tolerance),
           std::string(system_->name) + " is a discrete system: there is no method to choose");
  else if (tolerance && given().method)
    refuse("tolerance", to_text(*tolerance),
           "must be absent when `method` is given: it is for choosing one");
}

void SceneDraft::recommend() {
  Recommender recommender(given().system);
  recommender.take(scene_);
  const Recommendation one = recommender.chosen();
  given().method = one.description();
  check_method();
  given().method->substeps = one.substeps(scene_);
}

void SceneDraft::check_method() {
  auto& method = given().method;
  check_choice();
  if (wants_choice(given())) return;
  if (system_->discrete) {
    if (method)
      refuse("method", '"' + method->name + '"',
             std::string(system_->name) + " is a discrete system and takes no method");
    return;
  }
  if (!method) return;  // the recommended method is filled in once the state is known
  const auto names = listed(system_->methods, [](auto& m) { return m.method; });
  const MethodInfo* info = nullptr;
  for (const auto& m : system_->methods)
    if (m.method == method->name) info = catalogue().method(m.method);
  if (info == nullptr)
    return refuse("method.name", '"' + method->name + '"',
                  "must be one of " + names +
                      did_you_mean(method->name, system_->methods, &MethodOnSystem::method));
  check_order(*info);
  check_tolerance(*info);
  if (method->substeps.value_or(1) < 1 || method->substeps.value_or(1) > 1'000'000)
    refuse("method.substeps", std::to_string(*method->substeps), "must be 1 to 1000000");
  method->substeps = method->substeps.value_or(1);
  if (method->arithmetic.empty()) method->arithmetic = "compensated";
  if (method->arithmetic != "compensated" && method->arithmetic != "plain")
    refuse("method.arithmetic", '"' + method->arithmetic + '"', "must be compensated or plain");
  check_scalar();
}

void SceneDraft::check_scalar() {
  auto& method = *given().method;
  if (method.scalar.empty()) method.scalar = "double";
  if (method.scalar == "double") return;
  const auto rule = [&](const std::string& text) {
    refuse("method.scalar", '"' + method.scalar + '"', text);
  };
  if (method.scalar != "float") return rule("must be double or float");
  std::vector<MethodOnSystem> offered;
  std::ranges::copy_if(system_->methods, std::back_inserter(offered), &MethodOnSystem::in_float);
  if (offered.empty())
    rule("must be double: " + std::string(system_->name) + " is computed in nothing else");
  else if (std::ranges::find(offered, method.name, &MethodOnSystem::method) == offered.end())
    rule("of " + std::string(system_->name) + " is only for " +
         listed(offered, [](auto& m) { return m.method; }));
}

namespace {

/// Returns the name of the first method of a system that takes every Λ; "none" if there is none.
std::string takes_every_inertia(const SystemInfo& system) {
  for (const auto& on : system.methods)
    if (!on.takes) return std::string(on.method);
  return "none";
}

}  // namespace

/// Checks that the method takes Λ, once the system's own check has set Λ.
void SceneDraft::check_reach() {
  const auto& lambda = scene_.inertia();
  for (const auto& on : system_->methods)
    if (given().method && on.method == given().method->name && lambda.size() > 0 && on.takes &&
        !on.takes(lambda))
      refuse("method.name",
             '"' + given().method->name + "\" with N = " + std::to_string(lambda.size()),
             "is only for " + std::string(on.where) + "; " + takes_every_inertia(*system_) +
                 " takes every Lambda");
  const SystemEntry& entry = *system_entry(system_->name);
  if (!sound() || !given().method || entry.refusal == nullptr) return;
  const std::string rule = entry.refusal(scene_, given().method->name);
  if (!rule.empty()) refuse("method.name", '"' + given().method->name + '"', rule);
}

/// Checks `order`, which must be one that the method has, and fills it in unless the method has
/// none.
void SceneDraft::check_order(const MethodInfo& info) {
  auto& order = given().method->order;
  if (info.orders.empty()) {
    if (order)
      refuse("method.order", std::to_string(*order),
             "must be absent: " + std::string(info.name) + " has no order");
    return;
  }
  bool known = false;
  for (const int o : info.orders) known = known || order.value_or(info.default_order) == o;
  if (!known)
    refuse("method.order", std::to_string(*order),
           "for " + std::string(info.name) + " must be one of " +
               listed(info.orders, [](int o) { return std::to_string(o); }));
  order = order.value_or(info.default_order);
}

void SceneDraft::check_tolerance(const MethodInfo& info) {
  auto& tolerance = given().method->tolerance;
  if (!info.default_tolerance) {
    if (tolerance)
      refuse("method.tolerance", to_text(*tolerance),
             std::string(info.name) + " takes steps of a fixed size and no tolerance");
    return;
  }
  if (!(tolerance.value_or(info.default_tolerance) >= 1e-15 && tolerance.value_or(1e-6) <= 1))
    refuse("method.tolerance", to_text(*tolerance), "must be 1e-15 to 1");
  tolerance = tolerance.value_or(info.default_tolerance);
}

}  // namespace stiefel
