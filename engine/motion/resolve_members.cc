#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/motion/given_members.h"
#include "engine/motion/recommendation.h"
#include "engine/motion/resolve.h"
#include "engine/scene/members.h"
#include "engine/scene/scene_draft.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

constexpr std::size_t most_violations = 16;

/// A violation, the first member that has it, and whether later ones have the same.
struct OfMembers {
  Violation violation;
  int first;
  bool others = false;

  bool is(const Violation& other) const {
    return violation.field == other.field && violation.value == other.value &&
           violation.rule == other.rule;
  }
};

/// Calls `violations_of` with each member's index, one after another. Returns the violations of the
/// ensemble as a whole, else those of the first members that have any, at most 16. One that several
/// members have is returned once.
template <class ViolationsOf>
Violations check_each(const SceneDescription& ensemble, const Place& place,
                      const ViolationsOf& violations_of) {
  Violations wrong = check_members(ensemble, place);
  if (!wrong.empty()) return wrong;
  std::vector<OfMembers> found;
  std::size_t count = 0;
  for (int b = 0; b < *ensemble.members && count < most_violations; ++b) {
    stop_point();
    for (Violation& violation : violations_of(b)) {
      ++count;
      const auto before = std::ranges::find_if(found, [&](auto& one) { return one.is(violation); });
      if (before == found.end())
        found.push_back({std::move(violation), b});
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

}  // namespace

Violations check_members_before_choice(const SceneDescription& ensemble, double largest_repair,
                                       const Place& place) {
  return check_each(ensemble, place, [&](int b) {
    return check_before_choice(member_of(ensemble, b), largest_repair, place);
  });
}

std::expected<MethodDescription, Violations> recommended_for_members(
    const SceneDescription& ensemble, double largest_repair, const Place& place) {
  std::vector<Recommendation> left = recommended(ensemble.system);
  Violations wrong = check_each(ensemble, place, [&](int b) {
    SceneDraft draft(member_of(ensemble, b), largest_repair, place);
    check_scene(draft);
    if (draft.sound()) keep_what_takes(draft.scene(), left);
    return draft.violations();
  });
  if (!wrong.empty()) return std::unexpected(std::move(wrong));

  const Recommendation& one = left.front();
  MethodDescription method = one.description();
  int substeps = 1;
  wrong = check_each(ensemble, place, [&](int b) {
    SceneDescription member = member_of(ensemble, b);
    member.method = method;
    const auto scene = Scene::resolve(std::move(member), largest_repair, place);
    if (!scene) return scene.error();
    substeps = std::max(substeps, one.substeps(*scene));
    return Violations();
  });
  if (!wrong.empty()) return std::unexpected(std::move(wrong));
  method.substeps = substeps;
  return method;
}

std::expected<Scene, Violations> resolve_members(SceneDescription& ensemble, double largest_repair,
                                                 const Place& place) {
  if (lacks_method(ensemble)) {
    Violations wrong = check_members_before_choice(ensemble, largest_repair, place);
    if (wrong.empty()) wrong.push_back(method_not_chosen(ensemble, place));
    return std::unexpected(std::move(wrong));
  }
  std::expected<Scene, Violations> first = std::unexpected(Violations());
  bool common_epsilon = true;
  std::optional<GivenMembers> given;
  Violations wrong = check_each(ensemble, place, [&](int b) {
    if (given && given->any() && (*given)[static_cast<std::size_t>(b)]) return Violations();
    auto scene = Scene::resolve(member_of(ensemble, b), largest_repair, place);
    if (!scene) return std::move(scene.error());
    if (!first) {
      first = *std::move(scene);
      given.emplace(ensemble, *first, largest_repair);
    } else if (scene->description().epsilon != first->description().epsilon) {
      common_epsilon = false;
    }
    return Violations();
  });
  if (!wrong.empty()) return std::unexpected(std::move(wrong));

  // Otherwise each member chooses its own again.
  if (common_epsilon) ensemble.epsilon = first->description().epsilon;
  ensemble.method = first->description().method;
  if (ensemble.body && ensemble.body->attitude.empty())
    ensemble.body->attitude = first->description().body->attitude;
  return first;
}

}  // namespace stiefel
