#pragma once

#include <algorithm>
#include <vector>

#include "engine/linalg/arithmetic/lanes.h"

namespace stiefel {

/// Discrete rigid bodies side by side, a lane each: the map of order 2, its symmetric compositions,
/// and, with modified moments, PreprocessedMoserVeselov, where all of their stages are easy.
/// `Body` is DiscreteBody3 or DiscreteBody4.
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

  /// The first half of the palindrome of stages, the middle one included.
  explicit DiscreteBodies(std::vector<Inertia> stages) : stages_(std::move(stages)) {}

  /// The step in the lanes where it is easy, and which those are; the others are spoilt.
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
