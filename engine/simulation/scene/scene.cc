#include "stiefel/scene.h"

namespace stiefel {

std::span<const Scene> Scene::members() const {
  return members_ ? std::span<const Scene>(*members_) : std::span<const Scene>();
}

const Eigen::MatrixXd& Scene::block(const std::string& name) const {
  static const Eigen::MatrixXd none(0, 0);
  const auto found = blocks_.find(name);
  return found == blocks_.end() ? none : found->second;
}

}  // namespace stiefel
