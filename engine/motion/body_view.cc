#include "engine/motion/body_view.h"

#include <string>

#include "engine/motion/system_entry.h"

namespace stiefel {

BodyView::Two blocks_of_view(const Scene& scene) {
  const std::vector<BlockInfo>& blocks = system_entry(scene.system())->info.blocks;
  return {scene.block(std::string(blocks[0].name)), scene.block(std::string(blocks[1].name))};
}

Eigen::MatrixXd body_momentum(const Scene& scene) {
  const auto view = system_entry(scene.system())->view;
  return view ? view(scene).body(blocks_of_view(scene))[1] : scene.M();
}

}  // namespace stiefel
