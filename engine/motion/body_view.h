#pragma once

#include <array>
#include <functional>

#include "stiefel/scene.h"

namespace stiefel {

/// A system that is the rigid body (Q, M), or the discrete one, in other variables: how they are
/// read and written. Its blocks are N × N, in the order of the system's catalogue entry.
struct BodyView {
  using Two = std::array<Eigen::MatrixXd, 2>;
  std::function<Two(const Two& blocks)> body;  ///< returns Q and M of the left-invariant body
  std::function<Two(const Two& body)> blocks;  ///< returns the two blocks of Q and M
};

/// Returns the blocks of a scene of a view.
BodyView::Two blocks_of_view(const Scene& scene);
/// Returns M of the left-invariant body of a scene of a rigid body or of a view of it.
Eigen::MatrixXd body_momentum(const Scene& scene);

}  // namespace stiefel
