#include "stiefel/scene.h"

#include "engine/simulation/scene/members.h"
#include "engine/simulation/scene/scene_draft.h"

namespace stiefel {

std::expected<Scene, Violations> Scene::resolve(SceneDescription description, double largest_repair,
                                                const Place& place) {
  if (!description.members)
    return SceneDraft(std::move(description), largest_repair, place).resolve();
  auto members = resolve_members(description, largest_repair, place);
  if (!members) return std::unexpected(std::move(members.error()));
  Scene ensemble = members->front();
  ensemble.description_ = std::move(description);
  ensemble.members_ = std::make_shared<const std::vector<Scene>>(*std::move(members));
  return ensemble;
}

std::span<const Scene> Scene::members() const {
  return members_ ? std::span<const Scene>(*members_) : std::span<const Scene>();
}

const Eigen::MatrixXd& Scene::block(const std::string& name) const {
  static const Eigen::MatrixXd none(0, 0);
  const auto found = blocks_.find(name);
  return found == blocks_.end() ? none : found->second;
}

}  // namespace stiefel
