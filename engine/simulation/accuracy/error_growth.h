#pragma once

#include <vector>

#include "engine/simulation/accuracy/measurement.h"

namespace stiefel {

/// How the error of one candidate goes on beyond where its runs are cut short. Runs of longer steps
/// went further, and a method's errors have one course in time but for a factor: as theirs grew,
/// and beyond them all by the declared power of the time, between linear and quadratic as the last
/// half shows where that is not declared.
class ErrorGrowth {
 public:
  /// The factor by which the largest error of a run grows up to the horizon. The run is remembered
  /// for those to come, of the same candidate, as far as its errors are small.
  double beyond(const Candidate& candidate, const Run& run, const Samples& samples,
                std::int64_t horizon_steps);

  /// Whether the last three doublings of a run's time have the errors that the run before it has
  /// there, over `shorter`^order, `shorter` being how many of this run's steps are one of its: then
  /// they are the method's and not rounding, and go on as the earlier ones did. Errors of rounding
  /// are a walk: in single precision what follows is off by up to 100 x when foretold from a part.
  bool falls_as_declared(const Candidate& candidate, double shorter, const Run& run,
                         const Samples& samples) const;

 private:
  std::vector<double> course_;  ///< the largest error up to each sample
};

}  // namespace stiefel
