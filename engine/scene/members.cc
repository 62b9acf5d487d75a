#include "engine/scene/members.h"

#include <limits>

#include "engine/scene/scene_draft.h"
#include "stiefel/scene_fields.h"

namespace stiefel {
namespace {

/// A member's index among `count`, and the shape of its blocks.
struct Member {
  int index, count;
  std::size_t rows = 0, cols = 0;
};

/// Returns the member's part of a field of the ensemble, which depends on how the members share the
/// field.
template <class Value>
Value part(const Value& all, share::Common, const Member&) {
  return all;
}
std::optional<int> part(const std::optional<int>&, share::Ensemble, const Member&) {
  return std::nullopt;
}
std::vector<double> part(const std::vector<double>& all, share::Numbers numbers, const Member& of) {
  if (all.size() != numbers.each * static_cast<std::size_t>(of.count)) return all;
  const auto from = all.begin() + static_cast<std::ptrdiff_t>(numbers.each) * of.index;
  return {from, from + static_cast<std::ptrdiff_t>(numbers.each)};
}
std::vector<double> part(const std::vector<double>& all, share::NumberPerRow, const Member& of) {
  return of.rows > 0 ? part(all, share::Numbers{of.rows}, of) : all;
}
std::vector<double> part(const std::vector<double>& all, share::NumberPerColumn, const Member& of) {
  return of.cols > 0 ? part(all, share::Numbers{of.cols}, of) : all;
}
RowMatrix rows_of(const RowMatrix& all, const Member& of) {
  const Eigen::Index rows = all.rows() / of.count;
  return all.middleRows(rows * of.index, all.size() > 0 ? rows : 0);
}
std::map<std::string, Block> part(const std::map<std::string, Block>& all, share::Rows,
                                  const Member& of) {
  std::map<std::string, Block> one;
  for (const auto& [name, block] : all)
    one.emplace(name, Block(rows_of(block.values, of), rows_of(block.imaginary, of)));
  return one;
}

template <Description T>
T part(const T& all, const Member& of) {
  T one;
  for_each_field<T>(
      [&](const auto& field) { one.*field.member = part(all.*field.member, field.shared, of); });
  return one;
}
std::optional<BodyDescription> part(const std::optional<BodyDescription>& all, share::Common,
                                    const Member& of) {
  if (!all) return std::nullopt;
  return part(*all, of);
}

}  // namespace

SceneDescription member_of(const SceneDescription& all, int b) {
  Member one{b, *all.members};
  if (!all.initial.empty()) {
    const RowMatrix& block = all.initial.begin()->second.values;
    one.rows = static_cast<std::size_t>(block.rows() / one.count);
    one.cols = static_cast<std::size_t>(block.cols());
  }
  return part(all, one);
}

Violations check_members(const SceneDescription& all, const Place& place) {
  const int count = *all.members;
  if (count < 1 || count > Scene::max_members)
    return {place.violation("members", std::to_string(count),
                            "must be 1 to " + std::to_string(Scene::max_members))};
  Violations wrong;
  for (const auto& [name, block] : all.initial)
    if (block.values.rows() % count != 0 || block.imaginary.rows() % count != 0)
      wrong.push_back(place.violation(
          "initial." + name, shape_text(block.values.rows(), block.values.cols()),
          "must have the rows of all " + std::to_string(count) + " members, one after another"));
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
