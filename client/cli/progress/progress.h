#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>

#include "client/cli/progress/status_line.h"
#include "stiefel/client/session.h"

namespace stiefel::cli {

/// "[=====     ]  50 %  step 500 of 1000  250 steps/s  ETA 0:02" after that many seconds, without
/// the bar "50 %, step 500 of 1000, ...". Where the columns do not suffice, "of 1000" goes first,
/// then the rate and the step; percentage and ETA stay. No ETA before the first step.
std::string progress_line(std::int64_t step, std::int64_t to, double seconds, const Room& room);

/// A status line while a call computes the states of a session up to `to`. How far the server has
/// come it reads off the session's checkpoints.
class Progress {
 public:
  Progress(const client::Session& session, std::int64_t to);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// The caller knows more: a sample has arrived.
  void at(std::int64_t step);

  /// "at step 500 of 1000", as far as is known.
  std::string how_far() const;

 private:
  void ask();

  const client::Session& session_;
  std::int64_t to_;
  std::atomic<std::int64_t> step_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  StatusLine line_;  // last: its thread uses the others
};

}  // namespace stiefel::cli
