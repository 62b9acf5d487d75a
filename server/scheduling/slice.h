#pragma once

#include <cstdint>

#include "server/scheduling/job.h"

namespace stiefel::server {

/// The length of a slice of work, and the longest work that runs on the thread that received the
/// request, in nanoseconds.
inline constexpr double slice_nanoseconds = 2e6;
inline constexpr double inline_nanoseconds = 5e4;
/// The length of a slice on the worker that is kept for short calls: what a short call waits at
/// most before it begins there.
inline constexpr double brief_slice_nanoseconds = 2e5;

/// The steps of a slice on this thread: a number of the scene, not of the clock, so that it can be
/// tested. `step_cost` in nanoseconds.
std::int64_t slice_steps(double step_cost);

/// What slices of such steps are.
JobKind kind_of_steps(double step_cost);

/// While it lives, slices on this thread are so long.
class SliceLength {
 public:
  explicit SliceLength(double nanoseconds);
  ~SliceLength();
  SliceLength(const SliceLength&) = delete;
  SliceLength& operator=(const SliceLength&) = delete;
};

}  // namespace stiefel::server
