#pragma once

#include <memory>

#include "engine/accuracy/reference.h"
#include "engine/methods/concepts.h"

namespace stiefel::extremes {

/// The result of a scene's method without rounding: the same method with the same step, from the
/// same numbers, in quadruple precision. In dimensions from `wide_from` on it uses extended
/// precision, which is 2000 times finer than double and affordable there.
class Twin {
 public:
  static constexpr int wide_from = 16;

  virtual ~Twin() = default;
  virtual RunStatus advance(std::int64_t steps) = 0;
  virtual MotionState state() const = 0;
  /// Returns E / E_0 − 1, with E_0 the energy at the start.
  virtual double energy_error() const = 0;
};

/// Returns the twin of a scene of rigid_body or stiefel with a method of fixed steps; null for
/// other scenes. Each number of Λ, Q and the momentum is changed at random by up to `perturbation`
/// times its size.
std::unique_ptr<Twin> make_twin(const Scene& scene, double perturbation = 0, unsigned seed = 1);

/// Returns the condition of `steps` steps: the distance of the final states, as
/// MotionError::largest measures it, divided by the relative change of the initial numbers. It is
/// the larger one of two trials, at least 1.
double condition(const Scene& scene, std::int64_t steps);

}  // namespace stiefel::extremes
