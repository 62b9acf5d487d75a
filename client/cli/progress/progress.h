#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>

#include "client/cli/interrupt.h"
#include "client/cli/progress/status_line.h"
#include "stiefel/client/session.h"

namespace stiefel::cli {

/// Returns "[=====     ]  50 %  step 500 of 1000  250 steps/s  ETA 0:02" when `step` is reached
/// after `seconds`; without a bar, "50 %, step 500 of 1000, ...". If the columns do not suffice,
/// "of 1000" is left out first, then the rate, then the step; percentage and ETA stay. There is no
/// ETA before the first step.
std::string progress_line(std::int64_t step, std::int64_t to, double seconds, const Room& room);

/// Shows a status line while a call computes the states of a session up to `to`. It asks the server
/// for the session's cached steps to find out how far the call is.
class Progress {
 public:
  Progress(const client::Session& session, std::int64_t to);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Tells that the sample at `step` has arrived.
  void at(std::int64_t step);

  /// Returns the last step that is known: "at step 500 of 1000".
  std::string how_far() const;

 private:
  void ask();

  const client::Session& session_;
  std::int64_t to_;
  std::atomic<std::int64_t> step_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  StatusLine line_;  // the last member, because its thread uses the others
};

/// Returns what `call(progress)` returns, before which the command writes nothing. Throws
/// Interrupted, which says how far the call was, if a signal ended it.
template <class Call>
auto with_progress(const client::Session& session, std::int64_t to, const Call& call) {
  Progress progress(session, to);
  try {
    return call(progress);
  } catch (const client::Error&) {
    if (interrupted()) throw Interrupted(progress.how_far() + "; nothing was written");
    throw;
  }
}

}  // namespace stiefel::cli
