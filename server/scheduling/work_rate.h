#pragma once

#include <algorithm>
#include <chrono>
#include <mutex>

namespace stiefel::server {

/// Limits work per second by a bucket that fills at that rate up to the work of one second; work
/// empties it, even below zero. Thread-safe.
class WorkRate {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Seconds = std::chrono::duration<double>;

  /// `work_a_second` is in instructions; 0 means no limit.
  explicit WorkRate(double work_a_second = 0) : rate_(work_a_second), level_(work_a_second) {}

  bool limited() const { return rate_ > 0; }

  void spend(double work, Time now) {
    if (!limited()) return;
    const std::lock_guard lock(mutex_);
    fill(now);
    level_ -= work;
  }

  /// Returns the time until the bucket holds the work of `reserve` seconds, `reserve` < 1; 0 if it
  /// does.
  Seconds wait(Seconds reserve, Time now) {
    if (!limited()) return Seconds(0);
    const std::lock_guard lock(mutex_);
    fill(now);
    return std::max(reserve - Seconds(level_ / rate_), Seconds(0));
  }

 private:
  void fill(Time now) {
    if (now <= last_) return;
    if (last_ != Time()) level_ = std::min(level_ + rate_ * Seconds(now - last_).count(), rate_);
    last_ = now;
  }

  const double rate_;
  std::mutex mutex_;
  double level_;  // instructions; guarded by mutex_
  Time last_;     // guarded by mutex_
};

}  // namespace stiefel::server
