#include "engine/scene/members.h"

#include <limits>

#include "engine/scene/scene_draft.h"

namespace stiefel {
SceneDescription member_of(const SceneDescription& all, int b) {
  const int count = *all.members;
  // `each` numbers are common to all members; as many for each member are the members' in turn.
  const auto numbers = [&](const std::vector<double>& list, std::size_t each) {
    if (each == 0 || list.size() != each * static_cast<std::size_t>(count)) return list;
    const auto from = list.begin() + static_cast<std::ptrdiff_t>(each) * b;
    return std::vector<double>(from, from + static_cast<std::ptrdiff_t>(each));
  };
  const auto rows = [&](const RowMatrix& block) -> RowMatrix {
    const Eigen::Index each = block.rows() / count;
    return block.middleRows(each * b, block.size() > 0 ? each : 0);
  };
  std::size_t n = 0, N = 0;
  SceneDescription one{
      all.system, all.method,    {},          {}, {}, {}, {}, all.epsilon, all.parameter,
      all.step,   all.tolerance, all.horizon, {}};
  for (const auto& [name, block] : all.initial) {
    const Block& part =
        one.initial.emplace(name, Block(rows(block.values), rows(block.imaginary))).first->second;
    if (one.initial.size() > 1) continue;
    n = static_cast<std::size_t>(part.values.rows());
    N = static_cast<std::size_t>(part.values.cols());
  }
  one.inertia = numbers(all.inertia, N);
  one.inertia_u = numbers(all.inertia_u, n);
  one.inertia_v = numbers(all.inertia_v, N);
  if (const auto& body = all.body)
    one.body = {numbers(body->inertia_tensor, 6), numbers(body->moments, 3),
                numbers(body->attitude, 4), numbers(body->angular_velocity, 3)};
  return one;
}

Violations check_members(const SceneDescription& all) {
  const int count = *all.members;
  if (count < 1 || count > Scene::max_members)
    return {Violation{"members", std::to_string(count),
                      "must be 1 to " + std::to_string(Scene::max_members)}};
  Violations wrong;
  for (const auto& [name, block] : all.initial)
    if (block.values.rows() % count != 0 || block.imaginary.rows() % count != 0)
      wrong.push_back(Violation{
          "initial." + name, shape_text(block.values.rows(), block.values.cols()),
          "must have the rows of all " + std::to_string(count) + " members, one after another"});
  return wrong;
}

/// Repairs without a limit, because the members were checked with the ensemble. The bound is finite
/// because it is multiplied by the size of a block, which is 0 at rest: ∞ · 0 would be NaN.
Scene Members::operator[](std::size_t b) const {
  return Scene::resolve(member_of(*ensemble_, static_cast<int>(b)),
                        std::numeric_limits<double>::max())
      .value();
}

std::vector<Scene> Members::range(std::size_t first, std::size_t count) const {
  std::vector<Scene> some;
  some.reserve(count);
  for (std::size_t b = first; b < first + count; ++b) some.push_back((*this)[b]);
  return some;
}

const Eigen::MatrixXd& Scene::block(const std::string& name) const {
  static const Eigen::MatrixXd none(0, 0);
  const auto found = blocks_.find(name);
  return found == blocks_.end() ? none : found->second;
}

}  // namespace stiefel
