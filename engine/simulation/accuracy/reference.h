#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "engine/linalg/arithmetic/scalar.h"
#include "stiefel/tradeoff.h"

namespace stiefel {

class Simulation;

/// Attitude and momentum in the variables and axes in which a scene reports them: Q and M; Q and
/// Q̇Λ on V(n, N); the blocks Q and P where there is no M. No attitude in a momentum-only scene.
/// Attitude and momentum at a time. In a system with neither M, P nor Q̇ the momentum is its other
/// blocks: one block as it is, several as a column of their numbers, row by row.
struct MotionState {
  Matrix<long double> attitude, momentum;
  bool complex =
      false;  ///< columns come in pairs, the real parts of a column and its imaginary ones
};

/// The motion state of a simulation.
MotionState read_motion(const Scene& scene, const Simulation& now);

/// The error of a state against the exact one.
MotionError error_of(const MotionState& state, const MotionState& exact);

/// The exact motion of a scene as well as it is known: a function from time to its attitude and
/// momentum, with an estimate of its own error, which is never 0: that of two solutions of
/// different order and step by each other, and at least the rounding of what is reported.
class Reference {
 public:
  virtual ~Reference() = default;

  struct Answer {
    MotionState state;
    double error;  ///< as MotionError::largest measures it
  };
  /// The state at a time, |t| not below the last one's. Nothing when the motion ends before, or the
  /// token asks to stop.
  virtual std::optional<Answer> at(double time, const std::stop_token& stop) = 0;

  /// "Taylor series of order 31 in quadruple precision".
  virtual std::string description() const = 0;
  /// The work so far, in instructions.
  virtual double work() const = 0;
  /// The work that `at(time)` will have taken in all, predicted from the start of the motion, at
  /// least the work already done. Empty where only computing it would tell.
  virtual std::optional<double> predicted_work(double /*time*/, const std::stop_token& /*stop*/) {
    return std::nullopt;
  }
};

/// The requirements on a reference.
struct ReferenceNeed {
  double time;            ///< up to which; the step's sign is the scene's
  double budget;          ///< units of work it should cost at most
  bool quadruple = true;  ///< else extended precision will do
};

/// The best reference there is for the scene within the budget: a closed form where there is one
/// that is well-conditioned up to that time; else Taylor series of the scene's motion from its own
/// blocks, in quadruple precision where that can be afforded, else in extended; for a system
/// without a series extrapolation of its vector field. Null where its entry has none of these.
std::unique_ptr<Reference> make_reference(const Scene& scene, const ReferenceNeed& need);

/// Null where there is no closed form that holds.
std::unique_ptr<Reference> make_exact_reference(const Scene& scene, const ReferenceNeed& need);
/// The Taylor series in (Q, M), (Q, M_μ), (Q, S) or (Q, P); null without SystemEntry::motion.
std::unique_ptr<Reference> make_taylor_reference(const Scene& scene, const ReferenceNeed& need);
/// By the equations alone, in extended precision; null without SystemEntry::vector_field.
std::unique_ptr<Reference> make_extrapolated_reference(const Scene& scene,
                                                       const ReferenceNeed& need);

}  // namespace stiefel
