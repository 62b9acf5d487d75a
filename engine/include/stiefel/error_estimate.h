#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "stiefel/simulation.h"

namespace stiefel {

/// How far a simulation is from the exact motion of its scene, as well as that can be told. What it
/// says of attitude and momentum is the difference from a reference and that one's own error.
struct ErrorEstimate {
  /// max |Q − Q̂| + δ in the caller's axes, δ the reference's own error. Nothing without a frame,
  /// and where the difference is below half of δ: then the error is below 2δ.
  std::optional<double> attitude;
  /// max |M − M̂| / max |M̂| + δ; of Q̇Λ on V(n, N), of P where there is no M.
  std::optional<double> momentum;
  /// n = N = 3: the angle of the rotation from Q̂ to Q, radians; where there is `attitude`.
  std::optional<double> angle;
  double reference_error = 0;  ///< δ
  std::string reference;       ///< "Jacobi's closed form in quadruple precision"
  double work = 0;             ///< that it took, in units of work
  double run_work = 0;         ///< of the run itself
  /// Why there is neither attitude nor momentum; else empty.
  std::string missing;
  std::optional<std::int64_t> member = {};  ///< of an ensemble: the one with the largest error
};

/// Units of work from step 0 to where `now` is: steps of the map times step_weight, of an ensemble
/// those of all members; where every state comes from the one at step 0, one step.
double run_work(const Scene& scene, const Simulation& now);

/// The estimate for `now`, a simulation of `scene`, at the step where it is: after a run that ended
/// early the last good one. It takes at most `budget` units of work. What would take more is not
/// begun, as far as the start of the motion tells; `missing` then has the work predicted. Extended
/// precision where that is accurate enough to tell the error, else quadruple. Of an ensemble the
/// member with the largest error, or what one of them is missing.
ErrorEstimate estimate_error(const Scene& scene, const Simulation& now, double budget,
                             const std::stop_token& stop);

}  // namespace stiefel
