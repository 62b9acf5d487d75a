#pragma once

#include <functional>
#include <utility>

#include "engine/methods/support/concepts.h"

namespace stiefel {

/// A system's equations x' = field(x) from x(0) = start in extended precision, for a reference that
/// uses nothing else. The state has the blocks that the scene reports, one below the other: first
/// the frame Q with `frame_rows` rows, 0 for a system without a frame; then the momentum, or the
/// blocks that MotionState counts as such (accuracy/reference.h).
struct VectorField {
  using State = Matrix<long double>;

  State start;
  std::function<void(const State& x, State& dx)> field;
  Eigen::Index frame_rows = 0;
  /// The number of operations (sums and products) of one evaluation. If 0, an evaluation counts as
  /// four products of the state with square matrices.
  double operations = 0;
};

/// Returns the vector field of a system that is a template of its scalar, for example
/// vector_field(Brockett<long double>(...), H).
template <System S>
requires std::same_as<typename S::State, VectorField::State> VectorField vector_field(
    S system, const Eigen::MatrixXd& start, Eigen::Index frame_rows = 0, double operations = 0) {
  return {start.cast<long double>(),
          [system = std::move(system)](const VectorField::State& x,
                                       VectorField::State& dx) mutable { system.field(x, dx); },
          frame_rows, operations};
}

}  // namespace stiefel
