#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "client/cpp/session.h"

namespace stiefel::cli {

/// "[=====     ]  50 %  step 500 of 1000  250 steps/s"; `width` is the bar's.
std::string progress_line(std::int64_t step, std::int64_t to, double steps_per_second,
                          int width = 30);

/// A progress bar on stderr while a call runs, if that is a terminal and the call takes longer than
/// a second. How far the server has come it reads off the session's checkpoints.
class Progress {
 public:
  Progress(const client::Session& session, std::int64_t to);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// The caller knows more: a sample has arrived.
  void at(std::int64_t step) { step_.store(step, std::memory_order_relaxed); }

 private:
  void watch(const std::stop_token& stop);

  const client::Session& session_;
  std::int64_t to_;
  std::atomic<std::int64_t> step_ = 0;
  std::jthread watcher_;
};

}  // namespace stiefel::cli
