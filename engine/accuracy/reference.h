#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "engine/numbers/scalar.h"
#include "stiefel/tradeoff.h"

namespace stiefel {

class Simulation;

/// Attitude and momentum at a time, in the variables and axes in which a scene reports them: Q and
/// M; Q and Q̇Λ on V(n, N); the blocks Q and P where there is no M. A momentum-only scene has no
/// attitude. In a system with neither M, P nor Q̇ the momentum is its other blocks: a single block
/// as it is, several as a column of their numbers, row by row.
struct MotionState {
  Matrix<long double> attitude, momentum;
  /// Whether columns come in pairs: the real parts of a column, then its imaginary parts.
  bool complex = false;
};

/// Returns the motion state of a simulation.
MotionState read_motion(const Scene& scene, const Simulation& now);

/// Returns the error of a state against the exact one.
MotionError error_of(const MotionState& state, const MotionState& exact);

/// The best known approximation of the exact motion of a scene: a function from time to its
/// attitude and momentum, with an estimate of its own error. The estimate is the distance of two
/// solutions of different order and step, and at least the rounding of what is reported; it is
/// never 0.
class Reference {
 public:
  virtual ~Reference() = default;

  struct Answer {
    MotionState state;
    double error;  ///< in the measure of MotionError::largest
  };
  /// Returns the state at a time; |t| must not be below that of the last call. Returns nullopt when
  /// the motion ends before, or on a stop request.
  virtual std::optional<Answer> at(double time, const std::stop_token& stop) = 0;

  /// Describes the reference: "Taylor series of order 22 in extended precision".
  virtual std::string description() const = 0;
  /// Returns the work so far, in instructions.
  virtual double work() const = 0;
  /// Returns the work of one more answer at a time that the reference has reached.
  virtual double answer_work() const = 0;
  /// Predicts from the start of the motion the total work after `at(time)`, at least the work
  /// already done.
  virtual double predicted_work(double time, const std::stop_token& stop) = 0;
};

/// The requirements on a reference.
struct ReferenceNeed {
  double time;            ///< last time needed; the sign is that of the scene's step
  double budget;          ///< most units of work that it may cost
  bool quadruple = true;  ///< false: extended precision suffices, where there is a choice
};

/// Returns the best reference for the scene within the budget: a closed form where there is one
/// that is well-conditioned up to that time, for a body with N = 3 in quadruple precision if `need`
/// wants it; else Taylor series of the motion in extended precision, started from the scene's own
/// blocks. Returns null where the system's entry has neither.
std::unique_ptr<Reference> make_reference(const Scene& scene, const ReferenceNeed& need);

/// Returns a closed form as reference; null where there is none whose error estimate holds.
std::unique_ptr<Reference> make_exact_reference(const Scene& scene, const ReferenceNeed& need);
/// Returns the Taylor series in (Q, M), (Q, M_μ), (Q, S) or (Q, P); null without
/// SystemEntry::motion.
std::unique_ptr<Reference> make_taylor_reference(const Scene& scene, const ReferenceNeed& need);

}  // namespace stiefel
