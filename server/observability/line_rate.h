#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>

namespace stiefel::server {

/// Limits lines of one kind to `most` a second, and counts those that are left out. Thread-safe.
class LineRate {
 public:
  static constexpr int most = 10;
  using Clock = std::chrono::steady_clock;

  /// Returns whether a line may be written now.
  bool take(Clock::time_point now = Clock::now()) {
    const std::lock_guard lock(mutex_);
    if (now - begin_ >= std::chrono::seconds(1)) {
      begin_ = now;
      lines_ = 0;
    }
    if (lines_ < most) return ++lines_, true;
    ++left_out_;
    return false;
  }
  /// Returns the number of lines that were left out since the last call.
  std::int64_t take_left_out() {
    const std::lock_guard lock(mutex_);
    const std::int64_t count = left_out_;
    left_out_ = 0;
    return count;
  }

 private:
  std::mutex mutex_;
  Clock::time_point begin_;  // of the second; guarded by mutex_, as are the members below
  int lines_ = 0;            // in it
  std::int64_t left_out_ = 0;
};

}  // namespace stiefel::server
