#pragma once

#include <functional>

#include "stiefel/scene.h"

namespace stiefel {

/// A system that is the rigid body (Q, M), or the discrete one, in other variables: how they are
/// read and written. Blocks are N × N, stacked by rows in the order of the system's catalogue
/// entry.
struct BodyView {
  using Dense = Eigen::MatrixXd;
  std::function<Dense(const Dense& blocks)> body;  ///< returns Q over M of the left-invariant body
  std::function<Dense(const Dense& body)> blocks;  ///< returns the two blocks of Q over M
};

/// Returns the blocks of a scene of a view, stacked.
Eigen::MatrixXd blocks_of_view(const Scene& scene);
/// Returns M of the left-invariant body of a scene of a rigid body or of a view of it.
Eigen::MatrixXd body_momentum(const Scene& scene);

}  // namespace stiefel
