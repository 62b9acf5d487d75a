#pragma once

#include "server/scheduling/job.h"
#include "stiefel/scene.h"

namespace stiefel::server {

/// How the steps of a session are run.
struct StepKind {
  JobKind kind = JobKind::brief;  ///< of the jobs that compute them
  /// Whether a step may take many times its predicted time.
  bool unpredictable = false;
};

/// Whether the method chooses its own steps: `adaptive`.
bool chooses_steps(const Scene& scene);

/// Returns a bound of h‖Ω‖ along the motion of a scene that is not an ensemble, for a step of the
/// map. `rate` is ‖Ω‖ at the start. Since the energy is constant, ‖Ω‖ grows by at most the root of
/// the ratio of the largest to the least inertia.
double most_h_omega(const Scene& scene, double rate);

/// Returns the kind of steps of `step_cost` nanoseconds. A step is unpredictable if the method
/// chooses its own steps, or if it iterates and h‖Ω‖ may exceed 1: the solver may then follow the
/// solution from h = 0, which takes seconds where h‖Ω‖ is a billion. `h_omega` is the largest
/// `most_h_omega` of the members; it is used only where `kind_depends_on_rate`.
StepKind step_kind(const Scene& scene, double step_cost, double h_omega);

/// Whether `step_kind` depends on h‖Ω‖ for a scene, or a member of an ensemble, whose steps take
/// `step_cost` nanoseconds.
bool kind_depends_on_rate(const Scene& scene, double step_cost);

}  // namespace stiefel::server
