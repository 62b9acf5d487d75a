#pragma once

#include <cmath>
#include <cstdint>
#include <exception>

#include "stiefel/scene.h"

namespace stiefel::server {

/// Returns the predicted number of substeps that `adaptive` tries for one step,
///
///     1 + h‖Ω‖ (c h‖Ω‖ / tolerance)^{1/8},  c = 0.002,
///
/// since the error of a substep of length τ grows like (‖Ω‖τ)⁸. At most 10 000, after which the
/// engine ends a step (Adaptive::most_substeps). c fits the symmetric systems; other systems need
/// 0.3 to 2.2 times as many substeps, a flat ellipsoid twenty times as many.
inline double predicted_attempts(double h_omega, double tolerance) {
  constexpr double c = 0.002, most = 10000;
  const double attempts = 1 + h_omega * std::pow(c * h_omega / tolerance, 1.0 / 8);
  return attempts <= most ? attempts : most;  // also where it is NaN
}

/// The substeps that a call may try, over all members together, where the method chooses its own
/// steps.
struct AttemptLimit {
  /// A call may try this many times the predicted number.
  static constexpr double margin = 4;

  double each = 0;     ///< for each step of the call
  double longest = 0;  ///< for one step in addition, which is computed to its end
  double work = 0;     ///< instructions of one attempt

  /// Returns the number after which a call of that many steps begins no further step.
  double of(double steps) const { return each * steps; }
  /// Returns the most instructions of a call of that many steps.
  double most_work(double steps) const { return steps > 0 ? work * (of(steps) + longest) : 0; }
};

/// Thrown by `Cursor::advance` when the attempts of its session's AttemptLimit are used up.
class PriceReached : public std::exception {
 public:
  PriceReached(std::int64_t step, double work) : step_(step), work_(work) {}
  const char* what() const noexcept override { return "the call has taken the work of its price"; }
  /// The step that was reached, at which the session keeps its state.
  std::int64_t step() const { return step_; }
  /// The price of the call, in instructions.
  double work() const { return work_; }

 private:
  std::int64_t step_;
  double work_;
};

/// Whether the method chooses its own steps: `adaptive`.
bool chooses_steps(const Scene& scene);

/// Returns a bound of h‖Ω‖ along the motion of a scene that is not an ensemble, for a step of the
/// map. `rate` is ‖Ω‖ at the start. Since the energy is constant, ‖Ω‖ grows by at most the root of
/// the ratio of the largest to the least inertia.
double most_h_omega(const Scene& scene, double rate);

}  // namespace stiefel::server
