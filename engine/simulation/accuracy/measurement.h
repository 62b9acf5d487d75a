#pragma once

#include <vector>

#include "engine/simulation/accuracy/candidates.h"
#include "engine/simulation/accuracy/reference.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Returns the number of steps to the first state at or beyond a time.
std::int64_t steps_to(double horizon, double step);

/// The states of the reference with which runs are compared.
struct Samples {
  /// Ascending; include the half, the quarter, ... of the horizon.
  std::vector<std::int64_t> steps;
  std::vector<Reference::Answer> answers;
  std::string reference;
  double work = 0;
  /// Without samples: the work that the first one would take, as far as is known.
  double first_price = 0;

  std::int64_t last() const { return steps.empty() ? 0 : steps.back(); }
};

/// Computes samples as far towards `steps` as the reference gets within its budget. Without a
/// reference there are no samples, and `reference` is empty.
Samples take_samples(const Scene& scene, std::int64_t steps, const ReferenceNeed& need,
                     const std::stop_token& stop);

/// Errors of at least this size are as large as the quantity itself: they do not grow any more, and
/// do not yet fall with the step.
constexpr double saturated_error = 0.1;

/// A run of a scene, and its errors against the reference.
struct Run {
  RunStatus status;
  std::vector<MotionError> errors;  ///< at the samples that the run reached
  std::int64_t steps = 0;
  double work = 0;
  double spent = 0;  ///< part of the budget that was used: `work`, or more where steps failed
  double cpu_seconds = 0;
  double drift = 0;
  std::string drift_of;

  double largest_error(std::size_t samples) const;
};

enum class Watch { errors, errors_and_invariants, time };

/// Runs the scene up to a sample's step, or until the token requests a stop or `most_work` is used
/// up; the run status is then `cancelled`. Throws Stopped when an outer scope requires it.
Run run(const Scene& scene, double weight, const Samples& samples, std::int64_t to, Watch watch,
        const std::stop_token& stop, double most_work = StopScope::unlimited);

/// Returns the last sample that a run reaches with at most `work` when a step takes `step_work`; at
/// least the first sample.
std::int64_t affordable_steps(const Samples& samples, double step_work, double work);

}  // namespace stiefel
