#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "stiefel/simulation.h"

namespace stiefel {

/// The estimated distance of a simulation from the exact motion of its scene: the difference from a
/// reference plus the reference's own error δ.
struct ErrorEstimate {
  /// max |Q − Q̂| + δ in the caller's axes; absent without a frame. Both are absent where the
  /// difference is below δ: the error is then below 2δ.
  std::optional<double> attitude;
  /// max |M − M̂| / max |M̂| + δ. Q̇Λ takes the place of M on V(n, N), P where there is neither.
  std::optional<double> momentum;
  /// n = N = 3: the angle of the rotation from Q̂ to Q, in radians; present when `attitude` is.
  std::optional<double> angle;
  double reference_error = 0;  ///< δ
  /// Describes the reference: "Jacobi's closed form in quadruple precision".
  std::string reference;
  double work = 0;      ///< work of the estimate, in instructions
  double run_work = 0;  ///< work of the run, in instructions
  /// Why both attitude and momentum are absent; else empty.
  std::string missing;
  std::optional<std::int64_t> member = {};  ///< in an ensemble: the member with the largest error
};

/// Returns the units of work (instructions) from step 0 to the step of `now`: its map steps times
/// the instructions of one, which were counted beforehand for each method and size; for an ensemble
/// summed over all members. Where every state is computed directly from step 0, the run counts as
/// one step.
double run_work(const Scene& scene, const Simulation& now);

/// Estimates the error of `now`, a simulation of `scene`, at its current step; after a run that
/// ended early this is the last good step. Takes at most `budget` units of work: if the work
/// predicted from the start of the motion is larger, the estimate is not started and `missing`
/// gives the prediction. The reference is in extended precision; for a body with N = 3, where that
/// is not accurate enough, in quadruple precision. Where the error of the reference is larger than
/// the difference, `missing` says so. For an ensemble the result is that of the member with the
/// largest error, or of a member that has no estimate.
ErrorEstimate estimate_error(const Scene& scene, const Simulation& now, double budget,
                             const std::stop_token& stop);

}  // namespace stiefel
