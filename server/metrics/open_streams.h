#pragma once

#include <prometheus/collectable.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <unordered_set>
#include <vector>

namespace stiefel::server {

/// The open streams of messages, and how long the current message of each has waited for its
/// reader, because HTTP/2's windows are full and the network takes no more. Thread-safe.
class OpenStreams final : public prometheus::Collectable {
 public:
  using Clock = std::chrono::steady_clock;
  /// The wait of a message after which its reader counts as behind.
  static constexpr std::chrono::milliseconds behind{100};

  class Stream;

  /// stiefel_streams_open, stiefel_streams_behind, stiefel_stream_lag_seconds.
  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  mutable std::mutex mutex_;
  std::unordered_set<const Stream*> streams_;  // guarded by mutex_
};

/// An open stream, counted while the object lives. A message costs one reading of the clock.
class OpenStreams::Stream {
 public:
  explicit Stream(OpenStreams& all);
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream();

  /// Call `writing` when a message goes to gRPC, `written` when gRPC has sent it.
  void writing() noexcept;
  void written() noexcept { since_.store(not_waiting, std::memory_order_relaxed); }

 private:
  friend class OpenStreams;
  static constexpr Clock::rep not_waiting = 0;

  OpenStreams& all_;
  std::atomic<Clock::rep> since_ = not_waiting;
};

}  // namespace stiefel::server
