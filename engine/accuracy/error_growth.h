#pragma once

#include <vector>

#include "engine/accuracy/candidates.h"
#include "engine/accuracy/measurement.h"

namespace stiefel {

/// Extrapolates the errors of one candidate beyond the end of runs that are cut short. Runs with
/// longer steps went further, and the errors of a method at different steps differ in time only by
/// a factor. The errors therefore grow as those of longer steps did, and beyond the end of these by
/// the declared power of time; where none is declared, the power is between linear and quadratic
/// and taken from the last half of the run.
///
/// An error that grew more than eightfold in each of the last two doublings of the time grows
/// exponentially. It goes on so, up to the size of the quantity itself.
class ErrorGrowth {
 public:
  using Steps = std::vector<std::int64_t>;  ///< the steps at which a run has its errors

  /// Returns the factor by which the largest error of a run grows up to the horizon. Remembers the
  /// run, as far as its errors are small, for the next run of the same candidate, whose steps are
  /// half as long.
  ///
  /// The part of the error that the previous run's error and the order do not explain is taken for
  /// rounding, up to one unit of roundoff a step. Rounding grows in proportion to time, in
  /// compensated arithmetic less: it does not grow as the method's error does.
  double beyond(const Candidate& candidate, const Run& run, const Steps& steps,
                std::int64_t horizon_steps);

 private:
  /// Returns the part of the error at the end of a run that is rounding.
  double rounding_part(const Candidate& candidate, const Run& run) const;

  std::vector<double> course_;  ///< largest error up to each sample
};

}  // namespace stiefel
