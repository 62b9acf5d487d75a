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

constexpr int most_violations = 16;

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

/// Calls `visit` with each member as a scene with `method`, which may be nullopt. Members given by
/// `body` are one scene that takes their numbers; where the ensemble has a method, only the first
/// is visited. Returns the violations of the ensemble as a whole, else those of the first members
/// that have any, at most 16. One that several members have is returned once.
template <class Visit>
Violations check_each(const SceneDescription& ensemble,
                      const std::optional<MethodDescription>& method, double largest_repair,
                      const Place& place, const Visit& visit) {
  Violations wrong = check_members(ensemble, place);
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
    SceneDraft draft(member_of(ensemble, b), largest_repair, place);
    draft.given().method = method;
    check_scene(draft);
    if (draft.sound()) {
      if (!given) given.emplace(ensemble, draft.scene(), largest_repair);
      if (!like) like.emplace(draft.scene(), place);
      visit(draft.scene());
    }
    for (const Violation& violation : draft.violations()) {
      ++count;
      const auto before = std::ranges::find_if(found, [&](auto& one) { return one.is(violation); });
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

}  // namespace

Violations check_members_before_choice(const SceneDescription& ensemble, double largest_repair,
                                       const Place& place) {
  return check_each(ensemble, ensemble.method, largest_repair, place, [](const Scene&) {});
}

std::expected<MethodDescription, Violations> recommended_for_members(
    const SceneDescription& ensemble, double largest_repair, const Place& place) {
  std::vector<Recommendation> left = recommended(ensemble.system);
  Violations wrong = check_each(ensemble, ensemble.method, largest_repair, place,
                                [&](const Scene& scene) { keep_what_takes(scene, left); });
  if (!wrong.empty()) return std::unexpected(std::move(wrong));

  const Recommendation& one = left.front();
  MethodDescription method = one.description();
  int substeps = 1;
  wrong = check_each(ensemble, method, largest_repair, place, [&](const Scene& scene) {
    substeps = std::max(substeps, one.substeps(scene));
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
  Violations wrong =
      check_each(ensemble, ensemble.method, largest_repair, place, [&](const Scene& scene) {
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

}  // namespace stiefel
