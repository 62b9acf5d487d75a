#pragma once

#include <algorithm>
#include <vector>

#include "engine/numbers/pack.h"

namespace stiefel {

/// Discrete rigid bodies in the lanes of vector registers, one in each lane: the map of order 2,
/// its symmetric compositions, and, with modified moments, PreprocessedMoserVeselov. A lane is easy
/// when every stage finds its solution by the iteration for packs. `Body` is DiscreteBody3 or
/// DiscreteBody4.
template <class Body>
class DiscreteBodies {
 public:
  using Inertia = typename Body::Inertia;

  struct State {
    typename Body::State x;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
    }
  };

  /// `stages` is the first half of the palindromic sequence of stages, including the middle one.
  DiscreteBodies(std::vector<Inertia> stages, bool moves_frame)
      : stages_(std::move(stages)), body_(moves_frame) {}

  /// Makes the step in the easy lanes and returns them. The states in the other lanes become
  /// undefined.
  auto step_where_easy(State& state) {
    const std::size_t count = 2 * stages_.size() - 1;
    auto easy = stages_.front().positive;
    for (std::size_t stage = 0; stage < count; ++stage) {
      const Inertia& I = stages_[std::min(stage, count - 1 - stage)];
      easy = easy & body_.solve_where_easy(state.x, I);
      body_.transport(state.x, I);
    }
    return easy;
  }

 private:
  std::vector<Inertia> stages_;
  Body body_;
};

}  // namespace stiefel
