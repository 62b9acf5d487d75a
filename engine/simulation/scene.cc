#include "engine/simulation/scene.h"

#include "engine/simulation/scene_draft.h"

namespace stiefel {

std::expected<Scene, Violations> Scene::resolve(SceneDescription description) {
  return SceneDraft(std::move(description)).resolve();
}

const Eigen::MatrixXd& Scene::block(const std::string& name) const {
  static const Eigen::MatrixXd none(0, 0);
  const auto found = blocks_.find(name);
  return found == blocks_.end() ? none : found->second;
}

}  // namespace stiefel
