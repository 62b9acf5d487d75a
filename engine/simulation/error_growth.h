#pragma once

#include <vector>

#include "engine/simulation/measurement.h"

namespace stiefel {

/// How the error of one candidate goes on beyond where its runs are cut short. Runs of longer steps
/// went further, and a method's errors have one course in time but for a factor: as theirs grew,
/// and beyond them all by the declared power of the time, between linear and quadratic as the last
/// half shows where that is not declared.
class ErrorGrowth {
 public:
  /// What the largest error of a run becomes at the horizon, over what it is. The run is remembered
  /// for those to come, of the same candidate, as far as its errors are small.
  double beyond(const Candidate& candidate, const Run& run, const Samples& samples,
                std::int64_t horizon_steps);

 private:
  std::vector<double> course_;  ///< the largest error up to each sample
};

}  // namespace stiefel
