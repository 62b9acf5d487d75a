#include "stiefel/scene.h"

#include <limits>

#include "engine/scene/members.h"

namespace stiefel {

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
