#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiefel/stop.h"

namespace stiefel {

/// Follows a solution from t = `start` ≥ 0 to `end` along its branch. `solve(t)` starts from the
/// solution that it found last and returns whether it found one at t. Returns the largest t
/// reached: `end`, or the end of the branch to the relative `accuracy`, or 0 if no small t has a
/// solution. No stride is longer than `longest`, because an equation may have solutions again
/// beyond the end of the branch. From a `start` > 0 the first stride is the whole way.
template <class Solve>
double continuation(double end, Solve&& solve,
                    double longest = std::numeric_limits<double>::infinity(), double start = 0,
                    double accuracy = 1e-3) {
  constexpr double smallest = 1e-300;
  double reached = start, stride = start > 0 ? end - start : end / 4;
  int halvings = 0;
  while (reached < end) {
    stride = std::min(stride, longest);
    const double t = reached + stride < end ? reached + stride : end;
    stop_point();
    if (solve(t)) {
      reached = t;
      stride *= 2;
    } else if (reached == 0) {  // the first t is too large, by an unknown power of ten
      stride = std::ldexp(t, -(halvings += 5));
      if (stride < smallest * end) return 0;
    } else {
      stride = (t - reached) / 2;
      if (stride < accuracy / 2 * reached) return reached;
    }
  }
  return end;
}

}  // namespace stiefel
