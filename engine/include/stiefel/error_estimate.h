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
  /// max |Q − Q̂| + δ in the caller's axes. Empty without a frame, and where the difference is
  /// below δ/2: then the error is below 2δ.
  std::optional<double> attitude;
  /// max |M − M̂| / max |M̂| + δ; of Q̇Λ on V(n, N), of P where there is no M.
  std::optional<double> momentum;
  /// n = N = 3: the angle of the rotation from Q̂ to Q, radians; where there is `attitude`.
  std::optional<double> angle;
  double reference_error = 0;  ///< δ
  std::string reference;       ///< "Jacobi's closed form in quadruple precision"
  double work = 0;             ///< work of the estimate, in instructions
  double run_work = 0;         ///< work of the run, in instructions
  /// Why there is neither attitude nor momentum; else empty.
  std::string missing;
  std::optional<std::int64_t> member = {};  ///< in an ensemble: the member with the largest error
};

/// Units of work from step 0 to where `now` is: steps of the map times step_weight, of an ensemble
/// those of all members; where every state comes from the one at step 0, one step.
double run_work(const Scene& scene, const Simulation& now);

/// The estimate for `now`, a simulation of `scene`, at the step where it is: after a run that ended
/// early the last good one. Takes at most `budget` units of work. If the work predicted from the
/// start of the motion is larger, the estimate is not started and `missing` has the prediction. The
/// reference is in extended precision where that is accurate enough, else in quadruple. For an
/// ensemble the result is that of the member with the largest error, or of a member without an
/// estimate.
ErrorEstimate estimate_error(const Scene& scene, const Simulation& now, double budget,
                             const std::stop_token& stop);

}  // namespace stiefel
