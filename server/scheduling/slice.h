#pragma once

#include <algorithm>
#include <cstdint>

namespace stiefel::server {

/// The nominal speed of one thread, which converts between its processor time and work.
inline constexpr double instructions_a_nanosecond = 5;
/// The time between two looks of a call at whether it is to end or to send what it has, in
/// nanoseconds of predicted work.
inline constexpr double slice_nanoseconds = 2e5;

/// Returns the number of steps of a slice for steps of `step_cost` nanoseconds, which may be a
/// fraction. It depends on the scene and not on the clock, so that tests can predict it.
inline double slice_fraction(double step_cost) {
  return slice_nanoseconds / std::max(step_cost, 1.0);
}
/// Returns that number as whole steps, at least 1.
inline std::int64_t slice_steps(double step_cost) {
  return static_cast<std::int64_t>(std::max(1.0, slice_fraction(step_cost)));
}

}  // namespace stiefel::server
