#pragma once

#include <algorithm>
#include <vector>

#include "engine/linalg/discrete_body_3.h"

namespace stiefel {

/// Discrete rigid bodies side by side, a lane each: the map of order 2, its symmetric compositions,
/// and, with modified moments, PreprocessedMoserVeselov, where all of their stages are easy.
template <class P, bool frame, Arithmetic arithmetic>
class DiscreteBodies3 {
 public:
  struct State {
    Accumulator<typename So3<P, frame>::State, arithmetic> x;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
    }
  };

  /// The first half of the palindrome of stages, the middle one included.
  explicit DiscreteBodies3(std::vector<DiscreteInertia3<P>> stages) : stages_(std::move(stages)) {}

  /// The step in the lanes where it is easy, and which those are; the others are spoilt.
  Mask<P> step_where_easy(State& state) {
    const std::size_t count = 2 * stages_.size() - 1;
    Mask<P> easy = stages_.front().positive;
    for (std::size_t stage = 0; stage < count; ++stage) {
      const DiscreteInertia3<P>& I = stages_[std::min(stage, count - 1 - stage)];
      easy = easy & body_.solve_where_easy(state.x, I);
      body_.transport(state.x, I);
    }
    return easy;
  }

 private:
  std::vector<DiscreteInertia3<P>> stages_;
  DiscreteBody3<P, frame, arithmetic> body_;
};

}  // namespace stiefel
