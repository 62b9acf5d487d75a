#include "engine/motion/resolve.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "engine/motion/given_members.h"
#include "engine/motion/recommendation.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/members.h"
#include "engine/scene/near_name.h"
#include "engine/scene/scene_draft.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

/// Step indices up to this one are doubles.
constexpr double most_steps = 0x1p53;

/// Checks the method, if there is one, and what takes its place: a tolerance with a horizon.
void check_method_or_tolerance(SceneDraft& draft, const SystemInfo& system) {
  const auto& method = draft.given().method;
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
  else if (tolerance && method)
    draft.refuse("tolerance", to_text(*tolerance),
                 "must be absent when `method` is given: it is for choosing one");
  if (method && system.discrete)
    draft.refuse("method", '"' + method->name + '"',
                 std::string(system.name) + " is a discrete system and takes no method");
  else if (method)
    check_method(draft, system);
}

/// Checks a draft of a single motion, also by its system, and its method if there is one.
void check_scene(SceneDraft& draft) {
  const std::string& name = draft.given().system;
  if (const SystemEntry* entry = system_entry(name); entry == nullptr) {
    draft.refuse("system", name.empty() ? "absent" : '"' + name + '"',
                 "must be one of " + listed(catalogue().systems, &SystemInfo::name) +
                     did_you_mean(name, catalogue().systems, &SystemInfo::name));
  } else {
    draft.set_system(entry->info);
    check_method_or_tolerance(draft, entry->info);
    entry->check(draft);
    check_method_accepts_scene(draft, entry->info);
  }
  draft.check_step();
}

/// Whether the description is of a continuous system and has no method, so that a method must be
/// chosen for its tolerance or recommended before Scene::resolve accepts it.
bool lacks_method(const SceneDescription& description) {
  const SystemEntry* entry = system_entry(description.system);
  return !description.method && entry != nullptr && !entry->info.discrete;
}

Violation method_not_chosen(const SceneDescription& description) {
  return {"method", "absent",
          description.tolerance
              ? "must be chosen for the tolerance first (resolve_choosing)"
              : "must be given; resolve_recommending fills in the recommended method",
          "METHOD_NOT_CHOSEN"};
}

constexpr int most_violations = 16;

/// A violation, the first member that has it, and whether later ones have the same.
struct OfMembers {
  Violation violation;
  int first;
  bool others = false;
};

/// Calls `visit` with each member as a scene with `method`, which may be nullopt. Members given by
/// `body` are one scene that takes their numbers; where the ensemble has a method, only the first
/// is visited. Returns the violations of the ensemble as a whole, else those of the first members
/// that have any, at most 16. One that several members have is returned once.
template <class Visit>
Violations check_each(const SceneDescription& ensemble,
                      const std::optional<MethodDescription>& method, double largest_repair,
                      const Visit& visit) {
  Violations wrong = check_members(ensemble);
  if (!wrong.empty()) return wrong;
  std::vector<OfMembers> found;
  std::optional<GivenMembers> given;
  std::optional<SceneDraft> like;
  for (int b = 0, count = 0; b < *ensemble.members && count < most_violations; ++b) {
    stop_point();
    if (given && given->any())
      if (const auto body = (*given)[static_cast<std::size_t>(b)]) {
        if (ensemble.method) continue;
        like->set_body(*body);
        visit(like->scene());
        continue;
      }
    SceneDraft draft(member_of(ensemble, b), largest_repair);
    draft.given().method = method;
    check_scene(draft);
    if (draft.sound()) {
      if (!given) given.emplace(ensemble, draft.scene(), largest_repair);
      if (!like) like.emplace(draft.scene());
      visit(draft.scene());
    }
    for (const Violation& violation : draft.violations()) {
      ++count;
      const auto before = std::ranges::find(found, violation, &OfMembers::violation);
      if (before == found.end())
        found.push_back({violation, b});
      else
        before->others = true;
    }
  }
  for (auto& [violation, first, others] : found) {
    violation.value += " (member " + std::to_string(first) + (others ? " and others)" : ")");
    wrong.push_back(std::move(violation));
  }
  return wrong;
}

/// Returns the first recommended method that takes all members of an ensemble, which has neither
/// method nor tolerance, with enough substeps for the fastest member; or the violations of the
/// members.
std::expected<MethodDescription, Violations> recommended_for_members(
    const SceneDescription& ensemble, double largest_repair) {
  std::vector<Recommendation> left = recommended(ensemble.system);
  Violations wrong = check_each(ensemble, ensemble.method, largest_repair,
                                [&](const Scene& scene) { keep_what_takes(scene, left); });
  if (!wrong.empty()) return std::unexpected(std::move(wrong));

  const Recommendation& one = left.front();
  MethodDescription method = one.description();
  int substeps = 1;
  wrong = check_each(ensemble, method, largest_repair, [&](const Scene& scene) {
    substeps = std::max(substeps, one.substeps(scene));
  });
  if (!wrong.empty()) return std::unexpected(std::move(wrong));
  method.substeps = substeps;
  return method;
}

/// Checks the members of an ensemble as scenes of their own (scene/members.h), one after another,
/// and returns the first. Fills in what the description leaves open (order, ...), also in
/// `ensemble`, with the same values for all members. Only ε is chosen by each member, from its own
/// ‖M‖: `ensemble` gets it where all members agree, else none. The violations are those of the
/// first members that have any, at most 16.
std::expected<Scene, Violations> resolve_members(SceneDescription& ensemble,
                                                 double largest_repair) {
  if (lacks_method(ensemble)) {
    Violations wrong = check_before_choice(ensemble, largest_repair);
    if (wrong.empty()) wrong.push_back(method_not_chosen(ensemble));
    return std::unexpected(std::move(wrong));
  }
  std::expected<Scene, Violations> first = std::unexpected(Violations());
  bool common_epsilon = true;
  Violations wrong = check_each(ensemble, ensemble.method, largest_repair, [&](const Scene& scene) {
    if (!first) first = scene;
    common_epsilon &= scene.description().epsilon == first->description().epsilon;
  });
  if (!wrong.empty()) return std::unexpected(std::move(wrong));

  // Otherwise each member chooses its own again.
  if (common_epsilon) ensemble.epsilon = first->description().epsilon;
  ensemble.method = first->description().method;
  if (ensemble.body && ensemble.body->attitude.empty())
    ensemble.body->attitude = first->description().body->attitude;
  return first;
}

}  // namespace

bool wants_choice(const SceneDescription& description) {
  return description.tolerance && lacks_method(description);
}

Violations check_before_choice(const SceneDescription& description, double largest_repair) {
  if (description.members)
    return check_each(description, description.method, largest_repair, [](const Scene&) {});
  SceneDraft draft(description, largest_repair);
  check_scene(draft);
  return draft.violations();
}

std::expected<Scene, Violations> Scene::resolve(SceneDescription description,
                                                double largest_repair) {
  if (description.members) {
    auto ensemble = resolve_members(description, largest_repair);
    if (ensemble) ensemble->description_ = std::move(description);
    return ensemble;
  }
  SceneDraft draft(std::move(description), largest_repair);
  check_scene(draft);
  if (draft.sound() && lacks_method(draft.given())) draft.refuse(method_not_chosen(draft.given()));
  return draft.take();
}

std::expected<Scene, Violations> Scene::with(MethodDescription method) const {
  const bool narrower = method.scalar == "float" && !in_float();
  if (!members().empty() || narrower) {
    SceneDescription changed = description_;
    changed.method = std::move(method);
    return resolve(std::move(changed), drift_tolerance);
  }
  const SystemInfo& info = system_entry(system())->info;
  SceneDraft draft(*this);
  draft.set_system(info);
  draft.given().method = std::move(method);
  check_method_or_tolerance(draft, info);
  check_method_accepts_scene(draft, info);
  return draft.take();
}

std::expected<Scene, Violations> resolve_recommending(SceneDescription description,
                                                      double largest_repair) {
  if (!lacks_method(description) || description.tolerance)
    return Scene::resolve(std::move(description), largest_repair);
  if (description.members) {
    auto method = recommended_for_members(description, largest_repair);
    if (!method) return std::unexpected(std::move(method.error()));
    description.method = *std::move(method);
    return Scene::resolve(std::move(description), largest_repair);
  }
  SceneDraft draft(std::move(description), largest_repair);
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

}  // namespace stiefel
