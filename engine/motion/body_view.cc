#include "engine/motion/body_view.h"

#include <string>

#include "engine/motion/system_entry.h"

namespace stiefel {

Eigen::MatrixXd blocks_of_view(const Scene& scene) {
  const std::vector<BlockInfo>& blocks = system_entry(scene.system())->info.blocks;
  const Eigen::Index N = scene.dimension();
  Eigen::MatrixXd x(2 * N, N);
  x << scene.block(std::string(blocks[0].name)), scene.block(std::string(blocks[1].name));
  return x;
}

Eigen::MatrixXd body_momentum(const Scene& scene) {
  const auto view = system_entry(scene.system())->view;
  if (!view) return scene.M();
  return view(scene).body(blocks_of_view(scene)).bottomRows(scene.dimension());
}

}  // namespace stiefel
