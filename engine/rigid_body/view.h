#pragma once

#include <functional>

#include "engine/stepping/observables.h"
#include "stiefel/scene.h"

namespace stiefel {

/// A system that is the rigid body (Q, M) in other variables: how they are read and written. Blocks
/// are N × N, stacked by rows in the order of the system's catalogue entry.
struct BodyView {
  using Dense = Eigen::MatrixXd;
  std::function<Dense(const Dense& blocks)> body;  ///< returns Q over M of the left-invariant body
  std::function<Dense(const Dense& body)> blocks;  ///< returns the two blocks of Q over M
};

/// Returns the observables of a scene of a view: `body` has those of its (Q, M).
SharedObservables viewed(const Scene& scene, SharedObservables body);

/// Returns M of the left-invariant body of a scene of rigid_body or of a view.
Eigen::MatrixXd body_momentum(const Scene& scene);

}  // namespace stiefel
