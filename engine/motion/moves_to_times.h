#pragma once

#include <span>

#include "stiefel/run_status.h"

namespace stiefel {

/// A Simulation that goes to any time at once, not to steps alone. Found by dynamic_cast.
class MovesToTimes {
 public:
  virtual ~MovesToTimes() = default;
  /// Moves to the first of several times, counted from step 0, without a change of `step()`. The
  /// others are a hint of what the next calls will ask for, so that their states can be computed
  /// together.
  virtual RunStatus move_to(std::span<const double> times) = 0;
};

}  // namespace stiefel
