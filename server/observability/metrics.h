#pragma once

#include <prometheus/collectable.h>
#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/metric_family.h>
#include <prometheus/registry.h>

#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "server/scheduling/account.h"
#include "server/scheduling/memory_budget.h"
#include "server/scheduling/turns.h"
#include "server/sessions/registry.h"

namespace stiefel::server {

/// Returns the trace id, 32 hexadecimal digits, of a W3C header `traceparent`: version, trace id,
/// parent id and flags, in lower case. Empty if the header is not valid: wrong length, version ff,
/// or an id of zeros. Versions after 00 may have more behind the flags.
std::string_view trace_id(std::string_view traceparent);

/// Returns the name of a gRPC status code, 0 to 16: "OK", "CANCELLED" ...
const char* code_name(int code);

/// Counts and times calls by method and status code, and counts errors by reason. Thread-safe.
class CallMetrics final : public prometheus::Collectable {
 public:
  static constexpr int codes = 17;

  /// Counts only calls of these methods.
  explicit CallMetrics(const std::vector<std::string>& methods);

  class Running;

  /// Counts an error that a caller was told. `limit` is the limit that the request exceeds, or
  /// empty.
  void refused(const std::string& reason, const std::string& limit);

  /// stiefel_calls_total, stiefel_calls_running, stiefel_call_seconds, stiefel_refusals_total.
  std::vector<prometheus::MetricFamily> Collect() const override { return registry_.Collect(); }

 private:
  struct Method {
    std::string name;
    prometheus::Gauge& running;
    prometheus::Histogram& seconds;
    std::array<prometheus::Counter*, codes> ended;  // null for a code that is not usual
  };

  prometheus::Registry registry_;
  prometheus::Family<prometheus::Counter>& calls_;
  prometheus::Family<prometheus::Counter>& refusals_;
  std::vector<Method> methods_;
};

/// A running call, counted and timed from its construction to `end`.
class CallMetrics::Running {
 public:
  Running() = default;
  /// Counts nothing if `metrics` is null.
  Running(CallMetrics* metrics, std::string_view method);
  Running(Running&& other) noexcept
      : metrics_(other.metrics_),
        method_(std::exchange(other.method_, nullptr)),
        begin_(other.begin_) {}
  /// Counts the call as UNKNOWN if `end` was not called, for want of memory.
  ~Running();

  /// Counts the end of the call with gRPC's status code. Call it once.
  void end(int code) noexcept;

 private:
  using Clock = std::chrono::steady_clock;

  CallMetrics* metrics_ = nullptr;
  const Method* method_ = nullptr;
  Clock::time_point begin_;
};

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
  ~Stream() {
    const std::lock_guard lock(all_.mutex_);
    all_.streams_.erase(this);
  }

  /// Call `writing` when a message goes to gRPC, `written` when gRPC has sent it.
  void writing() noexcept {
    since_.store(Clock::now().time_since_epoch().count(), std::memory_order_relaxed);
  }
  void written() noexcept { since_.store(not_waiting, std::memory_order_relaxed); }

 private:
  friend class OpenStreams;
  static constexpr Clock::rep not_waiting = 0;

  OpenStreams& all_;
  std::atomic<Clock::rep> since_ = not_waiting;
};

/// Metrics of what a server holds and does, read on request. The parts must outlive this object.
class ServerMetrics final : public prometheus::Collectable {
 public:
  struct Parts {
    const Registry& registry;
    const Turns& turns;
    const int threads;
    const MemoryBudget& memory;
    std::string version;
  };
  explicit ServerMetrics(Parts parts) : parts_(std::move(parts)) {}

  /// Returns metrics of sessions, work, memory, threads and the build, and those of the process
  /// under Prometheus's usual names.
  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const Parts parts_;
  const std::chrono::system_clock::time_point start_ = std::chrono::system_clock::now();
};

}  // namespace stiefel::server
