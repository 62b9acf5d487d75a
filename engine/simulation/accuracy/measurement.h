#pragma once

#include <vector>

#include "engine/simulation/accuracy/candidates.h"
#include "engine/simulation/accuracy/reference.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel {

/// A time of interest in steps of a scene: the first state at it or beyond.
std::int64_t steps_to(double horizon, double step);

/// The reference's states that runs are compared with.
struct Samples {
  std::vector<std::int64_t> steps;  ///< ascending; the horizon's halves and quarters among them
  std::vector<Reference::Answer> answers;
  std::string reference;
  double work = 0;
  double first_price = 0;  ///< where there are none: what the first would take, as far as is known

  std::int64_t last() const { return steps.empty() ? 0 : steps.back(); }
};

/// As far towards `steps` as the reference gets within its budget; without one no samples, and an
/// empty `reference`.
Samples take_samples(const Scene& scene, std::int64_t steps, const ReferenceNeed& need,
                     const std::stop_token& stop);

/// An error as large as what it is the error of: it grows no more, and does not fall yet.
constexpr double saturated_error = 0.1;

/// A run of a scene, and what it missed the reference by.
struct Run {
  RunStatus status;
  std::vector<MotionError> errors;  ///< at the samples up to where it went
  std::int64_t steps = 0;
  double work = 0;
  double spent = 0;  ///< of the budget: `work`, or more where steps failed
  double cpu_seconds = 0;
  double drift = 0;
  std::string drift_of;

  double largest_error(std::size_t samples) const;
};

enum class Watch { errors, errors_and_invariants, time };

/// Up to a sample's step, or until the token asks to stop or `most_work` is used up: then the run
/// status is `cancelled`. Throws Stopped where a scope around it says so.
Run run(const Scene& scene, double weight, const Samples& samples, std::int64_t to, Watch watch,
        const std::stop_token& stop, double most_work = StopScope::unlimited);

/// The largest sample whose run takes at most so much work when a step takes `step_work`; the first
/// one at least.
std::int64_t affordable_steps(const Samples& samples, double step_work, double work);

}  // namespace stiefel
