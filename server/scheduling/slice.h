#pragma once

#include <algorithm>
#include <cstdint>

namespace stiefel::server {

/// The nominal speed of one thread, which converts between its processor time and work.
inline constexpr double instructions_a_nanosecond = 5;
/// The least and the most predicted nanoseconds of a slice: the work between two looks of a call at
/// whether it is to end or to send what it has.
inline constexpr double short_slice = 2e5, long_slice = 2e6;

/// Returns the number of steps of a slice for steps of `step_cost` nanoseconds, which may be a
/// fraction: a hundred, in a slice no longer than a turn (turns.h). In long slices an ensemble
/// takes many steps of a part of its members before it fetches the next part. The number depends on
/// the scene and not on the clock, so that tests can predict it.
inline double slice_fraction(double step_cost) {
  const double cost = std::max(step_cost, 1.0);
  return std::clamp(100 * cost, short_slice, long_slice) / cost;
}
/// Returns that number as whole steps, at least 1.
inline std::int64_t slice_steps(double step_cost) {
  return static_cast<std::int64_t>(std::max(1.0, slice_fraction(step_cost)));
}

}  // namespace stiefel::server
