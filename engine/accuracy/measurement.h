#pragma once

#include <limits>
#include <vector>

#include "engine/accuracy/candidates.h"
#include "engine/accuracy/reference.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// Returns the number of steps to the first state at or beyond a time.
std::int64_t steps_to(double horizon, double step);

/// The states of the reference with which runs are compared.
struct Samples {
  std::vector<std::int64_t> steps;  ///< ascending; include the coarse ones
  std::vector<Reference::Answer> answers;
  std::string reference;
  double work = 0;
  double all_work = 0;  ///< work of the reference at every step, as far as is known
  /// Without samples: the work that the first one would take, as far as is known.
  double first_price = 0;

  std::int64_t last() const { return steps.empty() ? 0 : steps.back(); }
};

enum class Density { coarse, dense };

/// Returns the bytes of one sample of a scene.
double sample_bytes(const Scene& scene);

/// Computes samples as far towards `steps` as the reference gets within its budget. Coarse ones,
/// with which a run that is cut short can be compared, are at eight equal distances, and at the
/// half, the quarter, ... of the horizon. Dense samples are all steps, where these take at most the
/// budget and `most_bytes`; else they take at most a quarter of the budget, and are the coarse ones
/// and up to 512 more, one at a pseudo-random place in each of as many equal parts of the horizon,
/// so that no period of the motion hides an error from them. Without a reference there are no
/// samples, and `reference` is empty.
Samples take_samples(const Scene& scene, std::int64_t steps, Density density,
                     const ReferenceNeed& need, const std::stop_token& stop,
                     double most_bytes = Choice::most_sample_bytes);

/// Returns the units of work of comparing one state with that of the reference.
double comparison_work(const Scene& scene);

/// Errors of at least this size are as large as the quantity itself: they do not grow any more, and
/// do not yet fall with the step.
constexpr double saturated_error = 0.1;

/// A run of a scene, and its errors against the reference.
struct Run {
  RunStatus status;
  std::vector<MotionError> errors;  ///< at the steps to compare that the run reached
  std::int64_t steps = 0;
  double work = 0;
  /// Part of the budget that was used: that of the comparisons, and `work`, or more where steps
  /// failed.
  double spent = 0;
  double cpu_seconds = 0;
  double drift = 0;
  std::string drift_of;
  std::size_t member = 0;  ///< of several motions that with the largest error

  double largest_error(std::size_t count) const;
};

enum class Watch {
  errors,                 ///< a closed form computes the compared states alone
  errors_and_invariants,  ///< every state is computed
  time,                   ///< every state is computed, none compared
};

/// How far a run goes: up to the last of `compared`, which are steps of the samples, that is at
/// most `to`, or until the token requests a stop or `most_work` is used up; the run status is then
/// `cancelled`. It ends at the first compared step where the error exceeds `most_error`.
struct RunBounds {
  const std::vector<std::int64_t>& compared;
  std::int64_t to;
  Watch watch;
  std::stop_token stop = {};
  double most_work = StopScope::unlimited, most_error = infinity;
};

/// Runs the scene. Throws Stopped when an outer scope requires it.
Run run(const Scene& scene, double weight, const Samples& samples, const RunBounds& bounds);

/// Returns the last of `steps` that a run reaches with at most `work` when a step takes
/// `step_work`; at least the first.
std::int64_t affordable_steps(const std::vector<std::int64_t>& steps, double step_work,
                              double work);

}  // namespace stiefel
