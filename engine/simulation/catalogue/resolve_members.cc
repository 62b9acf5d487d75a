#include <algorithm>
#include <optional>
#include <utility>

#include "engine/simulation/catalogue/methods/recommendation.h"
#include "engine/simulation/catalogue/resolve.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/scene/members.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

constexpr std::size_t most_violations = 16;

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

namespace {

/// Resolves member after member and calls `look` with each. Returns the violations of the first
/// members that have any, at most 16.
template <class Look>
Violations resolve_each(const SceneDescription& ensemble, double largest_repair, const Place& place,
                        const Look& look) {
  Violations wrong;
  for (int b = 0; b < *ensemble.members && wrong.size() < most_violations; ++b) {
    stop_point();
    auto resolved = Scene::resolve(member_of(ensemble, b), largest_repair, place);
    if (resolved)
      look(*resolved);
    else
      add_of_member(static_cast<std::size_t>(b), resolved.error(), wrong);
  }
  return wrong;
}

/// Gives all members one method, with enough substeps for the fastest.
Violations recommend(const Recommendation& one, SceneDescription& ensemble, double largest_repair,
                     const Place& place) {
  ensemble.method = one.description();
  int substeps = 1;
  Violations wrong = resolve_each(ensemble, largest_repair, place, [&](const Scene& member) {
    substeps = std::max(substeps, one.substeps(member));
  });
  ensemble.method->substeps = substeps;
  return wrong;
}

}  // namespace

std::expected<Scene, Violations> resolve_members(SceneDescription& ensemble, double largest_repair,
                                                 const Place& place) {
  Violations wrong;
  if (wants_choice(ensemble)) {
    wrong = check_members_before_choice(ensemble, largest_repair, place);
    if (wrong.empty()) wrong.push_back(method_not_chosen(place));
    return std::unexpected(std::move(wrong));
  }
  wrong = check_members(ensemble, place);
  if (!wrong.empty()) return std::unexpected(std::move(wrong));
  std::optional<Recommender> recommender;
  const SystemEntry* system = system_entry(ensemble.system);
  if (!ensemble.method && system != nullptr && !system->info.discrete)
    recommender.emplace(ensemble.system);
  std::optional<double> epsilon;
  bool common_epsilon = true, any = false;
  wrong = resolve_each(ensemble, largest_repair, place, [&](const Scene& member) {
    const auto& own = member.description().epsilon;
    if (!std::exchange(any, true)) epsilon = own;
    common_epsilon = common_epsilon && own == epsilon;
    if (recommender) recommender->take(member);
  });
  if (wrong.empty() && recommender)
    wrong = recommend(recommender->chosen(), ensemble, largest_repair, place);
  if (!wrong.empty()) return std::unexpected(std::move(wrong));

  if (common_epsilon) ensemble.epsilon = epsilon;  // otherwise each member chooses its own again
  auto first = Scene::resolve(member_of(ensemble, 0), largest_repair, place);
  if (!first) return first;
  ensemble.method = first->description().method;
  if (ensemble.body && ensemble.body->attitude.empty())
    ensemble.body->attitude = first->description().body->attitude;
  return first;
}

}  // namespace stiefel
