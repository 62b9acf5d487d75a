#include <algorithm>

#include "engine/simulation/catalogue/methods/recommendation.h"
#include "engine/simulation/catalogue/resolve.h"
#include "engine/simulation/scene/members.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

constexpr std::size_t most_violations = 16;

/// One method for all of them.
MethodDescription recommended_method(std::span<const Scene> members) {
  const Recommendation one = recommendation_for(members);
  MethodDescription method = one.description();
  method.substeps = one.substeps(members);
  return method;
}

void add_of_member(std::size_t member, const Violations& violations, Violations& wrong) {
  for (Violation violation : violations) {
    violation.value += " (member " + std::to_string(member) + ")";
    wrong.push_back(std::move(violation));
  }
}

}  // namespace

Violations check_members_before_choice(const SceneDescription& ensemble, double largest_repair,
                                       const Place& place) {
  Violations wrong = check_members(ensemble, place);
  if (!wrong.empty()) return wrong;
  for (int b = 0; b < *ensemble.members && wrong.size() < most_violations; ++b) {
    stop_point();
    add_of_member(static_cast<std::size_t>(b),
                  check_before_choice(member_of(ensemble, b), largest_repair, place), wrong);
  }
  return wrong;
}

std::expected<std::vector<Scene>, Violations> resolve_members(SceneDescription& ensemble,
                                                              double largest_repair,
                                                              const Place& place) {
  Violations wrong;
  if (wants_choice(ensemble)) {
    wrong = check_members_before_choice(ensemble, largest_repair, place);
    if (wrong.empty()) wrong.push_back(method_not_chosen(place));
    return std::unexpected(std::move(wrong));
  }
  wrong = check_members(ensemble, place);
  if (!wrong.empty()) return std::unexpected(std::move(wrong));
  std::vector<Scene> members;
  members.reserve(static_cast<std::size_t>(*ensemble.members));
  const auto refuse = [&](std::size_t member, const Violations& violations) {
    add_of_member(member, violations, wrong);
  };
  for (int b = 0; b < *ensemble.members && wrong.size() < most_violations; ++b) {
    stop_point();
    auto resolved = Scene::resolve(member_of(ensemble, b), largest_repair, place);
    if (resolved)
      members.push_back(*std::move(resolved));
    else
      refuse(static_cast<std::size_t>(b), resolved.error());
  }
  if (!wrong.empty()) return std::unexpected(std::move(wrong));
  if (!ensemble.method && !members.front().method().empty()) {
    ensemble.method = recommended_method(members);
    for (std::size_t b = 0; b < members.size() && wrong.size() < most_violations; ++b) {
      stop_point();
      auto changed = members[b].with(*ensemble.method, place);
      if (changed)
        members[b] = *std::move(changed);
      else
        refuse(b, changed.error());
    }
    if (!wrong.empty()) return std::unexpected(std::move(wrong));
  }

  const SceneDescription& first = members.front().description();
  ensemble.method = first.method;
  if (std::ranges::all_of(
          members, [&](const Scene& one) { return one.description().epsilon == first.epsilon; }))
    ensemble.epsilon = first.epsilon;  // else each chooses its own again
  if (ensemble.body && ensemble.body->attitude.empty())
    ensemble.body->attitude = first.body->attitude;
  return members;
}

}  // namespace stiefel
