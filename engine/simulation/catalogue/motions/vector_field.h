#pragma once

#include <functional>
#include <utility>

#include "engine/systems/concepts.h"

namespace stiefel {

/// A system's equations x' = field(x) from x(0) = start in extended precision, for a reference that
/// uses nothing else. The state is the blocks as the scene reports them, stacked by rows: the first
/// `frame_rows` rows are the frame Q, if it has one; the other rows count as its momentum
/// (accuracy/reference.h).
struct VectorField {
  using State = Matrix<long double>;

  State start;
  std::function<void(const State& x, State& dx)> field;
  Eigen::Index frame_rows = 0;
};

/// Returns the vector field of a system that is a template of its scalar, for example
/// vector_field(Brockett<long double>(...), H).
template <System S>
requires std::same_as<typename S::State, VectorField::State> VectorField
vector_field(S system, const Eigen::MatrixXd& start, Eigen::Index frame_rows = 0) {
  return {start.cast<long double>(),
          [system = std::move(system)](const VectorField::State& x,
                                       VectorField::State& dx) mutable { system.field(x, dx); },
          frame_rows};
}

}  // namespace stiefel
