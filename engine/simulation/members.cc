#include "engine/simulation/members.h"

#include <algorithm>

#include "engine/simulation/scene_draft.h"

namespace stiefel {
namespace {

constexpr std::size_t most_violations = 16;

/// Member b's numbers among those of `count` members, `each` a member, or those of all.
std::vector<double> part(const std::vector<double>& all, std::size_t each, int count, int b) {
  if (all.size() != each * static_cast<std::size_t>(count)) return all;
  const auto from = all.begin() + static_cast<std::ptrdiff_t>(each) * b;
  return {from, from + static_cast<std::ptrdiff_t>(each)};
}

RowMatrix part(const RowMatrix& all, int count, int b) {
  const Eigen::Index rows = all.rows() / count;
  return all.middleRows(rows * b, all.size() > 0 ? rows : 0);
}

SceneDescription member(const SceneDescription& all, int b) {
  const int count = *all.members;
  SceneDescription one = all;
  one.members.reset();
  for (auto& [name, block] : one.initial)
    block = Block(part(block.values, count, b), part(block.imaginary, count, b));
  if (!all.initial.empty()) {
    const RowMatrix& block = all.initial.begin()->second.values;
    const auto rows = static_cast<std::size_t>(block.rows() / count);
    const auto cols = static_cast<std::size_t>(block.cols());
    one.inertia = part(all.inertia, cols, count, b);
    one.inertia_u = part(all.inertia_u, rows, count, b);
    one.inertia_v = part(all.inertia_v, cols, count, b);
  }
  if (all.body) {
    one.body->inertia_tensor = part(all.body->inertia_tensor, 6, count, b);
    one.body->moments = part(all.body->moments, 3, count, b);
    one.body->attitude = part(all.body->attitude, 4, count, b);
    one.body->angular_velocity = part(all.body->angular_velocity, 3, count, b);
  }
  return one;
}

Violations check(const SceneDescription& all) {
  const int count = *all.members;
  if (count < 1 || count > Scene::max_members)
    return {
        {"members", std::to_string(count), "must be 1 to " + std::to_string(Scene::max_members)}};
  Violations wrong;
  for (const auto& [name, block] : all.initial)
    if (block.values.rows() % count != 0 || block.imaginary.rows() % count != 0)
      wrong.push_back({"initial." + name, shape_text(block.values.rows(), block.values.cols()),
                       "must have as many rows for each of " + std::to_string(count) + " members"});
  if (all.tolerance && !all.method)
    wrong.push_back({"tolerance", to_text(*all.tolerance),
                     "must be absent in an ensemble: name a method (stiefel tradeoff measures one "
                     "member)"});
  return wrong;
}

}  // namespace

std::expected<std::vector<Scene>, Violations> resolve_members(SceneDescription& ensemble,
                                                              double largest_repair) {
  Violations wrong = check(ensemble);
  if (!wrong.empty()) return std::unexpected(std::move(wrong));
  std::vector<Scene> members;
  members.reserve(static_cast<std::size_t>(*ensemble.members));
  for (int b = 0; b < *ensemble.members && wrong.size() < most_violations; ++b) {
    auto resolved = Scene::resolve(member(ensemble, b), largest_repair);
    if (resolved) {
      members.push_back(*std::move(resolved));
      continue;
    }
    for (Violation& violation : resolved.error()) {
      violation.value += " (member " + std::to_string(b) + ")";
      wrong.push_back(std::move(violation));
    }
  }
  if (!wrong.empty()) return std::unexpected(std::move(wrong));

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
