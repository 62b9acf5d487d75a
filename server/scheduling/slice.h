#pragma once

#include <cstdint>

#include "server/scheduling/job.h"

namespace stiefel::server {

/// The length of a slice of work, and the longest work that runs on the thread that received the
/// request, in nanoseconds.
inline constexpr double slice_nanoseconds = 2e6;
inline constexpr double inline_nanoseconds = 5e4;
/// The length of a slice of a longer job on the worker kept for short calls, in nanoseconds: the
/// longest that a short call waits there before it begins.
inline constexpr double brief_slice_nanoseconds = 2e5;

/// Returns the number of steps of a slice on this thread for steps of `step_cost` nanoseconds. It
/// depends on the scene and not on the clock, so that tests can predict it.
std::int64_t slice_steps(double step_cost);

/// The kind of a job whose steps cost `step_cost` nanoseconds each.
JobKind kind_of_steps(double step_cost);
/// The kind of a job that does `work` instructions in one piece, which may take ten milliseconds
/// before it counts as long.
inline JobKind kind_of_piece(double work) {
  return work <= 5 * short_work ? JobKind::sliced : JobKind::unsliced;
}

/// Sets the length of slices on this thread, in nanoseconds, while the object lives. Its destructor
/// sets the previous length again.
class SliceLength {
 public:
  explicit SliceLength(double nanoseconds);
  ~SliceLength();
  SliceLength(const SliceLength&) = delete;
  SliceLength& operator=(const SliceLength&) = delete;

 private:
  const double previous_;
};

}  // namespace stiefel::server
