#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "server/scheduling/job.h"

namespace stiefel::server {

/// The length of a slice of work, and the longest work that runs on the thread that received the
/// request, in nanoseconds.
inline constexpr double slice_nanoseconds = 2e6;
inline constexpr double inline_nanoseconds = 5e4;
/// The length of a slice of a longer job on the worker kept for short calls, in nanoseconds: the
/// longest that a short call waits there before it begins.
inline constexpr double brief_slice_nanoseconds = 2e5;
/// The length of slices on this thread, in nanoseconds.
inline thread_local double slice_length = slice_nanoseconds;

/// Returns the number of steps of a slice on this thread for steps of `step_cost` nanoseconds,
/// which may be a fraction. It depends on the scene and not on the clock, so that tests can predict
/// it.
inline double slice_fraction(double step_cost) { return slice_length / std::max(step_cost, 1.0); }
/// Returns that number as whole steps, at least 1.
inline std::int64_t slice_steps(double step_cost) {
  return static_cast<std::int64_t>(std::max(1.0, slice_fraction(step_cost)));
}

/// The kind of a job whose steps cost `step_cost` nanoseconds each.
inline JobKind kind_of_steps(double step_cost) {
  if (step_cost <= brief_slice_nanoseconds) return JobKind::brief;
  return step_cost <= slice_nanoseconds ? JobKind::sliced : JobKind::unsliced;
}
/// The kind of a job that does `work` instructions in one piece, which may take ten milliseconds
/// before it counts as long.
inline JobKind kind_of_piece(double work) {
  return work <= 5 * short_work ? JobKind::sliced : JobKind::unsliced;
}

/// Sets the length of slices on this thread, in nanoseconds, while the object lives. Its destructor
/// sets the previous length again.
class SliceLength {
 public:
  explicit SliceLength(double nanoseconds) : previous_(std::exchange(slice_length, nanoseconds)) {}
  ~SliceLength() { slice_length = previous_; }
  SliceLength(const SliceLength&) = delete;
  SliceLength& operator=(const SliceLength&) = delete;

 private:
  const double previous_;
};

}  // namespace stiefel::server
