#pragma once

#include <memory>

#include "engine/maps/map.h"
#include "engine/simulation/accuracy/reference.h"

namespace stiefel::extremes {

/// A scene's own method with its own step in quadruple precision, from the same numbers: the result
/// of the scene's method without rounding. In dimensions from `wide_from` on in extended precision,
/// which is 2000 times finer than double and affordable there.
class Twin {
 public:
  static constexpr int wide_from = 16;

  virtual ~Twin() = default;
  virtual RunStatus advance(std::int64_t steps) = 0;
  virtual MotionState state() const = 0;
  /// Energy relative to that at the start, minus 1.
  virtual double energy_error() const = 0;
};

/// The twin of a scene of rigid_body or stiefel with a method of fixed steps; null for other
/// scenes. Λ, Q and the momentum are moved at random by `perturbation` times each number's size.
std::unique_ptr<Twin> make_twin(const Scene& scene, double perturbation = 0, unsigned seed = 1);

/// How far the states drift apart, as MotionError::largest measures it, when every number of the
/// start is moved by one part: the condition of `steps` steps. The larger of two trials.
double condition(const Scene& scene, std::int64_t steps);

}  // namespace stiefel::extremes
