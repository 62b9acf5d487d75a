#pragma once

#include <prometheus/collectable.h>
#include <prometheus/histogram.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stiefel::server {

/// Returns the name of a gRPC status code, 0 to 16: "OK", "CANCELLED" ...
const char* code_name(int code);

/// Counts and times calls by method and status code, and counts errors by reason. A call costs two
/// atomic additions, two readings of the clock and one observation under the method's own lock.
/// Thread-safe.
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
  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  struct Method {
    explicit Method(std::string its_name);

    const std::string name;
    std::atomic<std::uint64_t> begun = 0;
    std::array<std::atomic<std::uint64_t>, codes> ended{};
    prometheus::Histogram seconds;
  };
  Method* find(std::string_view name);
  prometheus::MetricFamily calls() const;
  prometheus::MetricFamily running() const;
  prometheus::MetricFamily seconds() const;
  prometheus::MetricFamily refusals() const;

  std::deque<Method> methods_;
  mutable std::mutex mutex_;
  /// By reason and limit; guarded by mutex_.
  std::map<std::pair<std::string, std::string>, std::uint64_t> refusals_;
};

/// A running call, counted and timed from its construction to `end`.
class CallMetrics::Running {
 public:
  Running() = default;
  /// Counts nothing if `metrics` is null.
  Running(CallMetrics* metrics, std::string_view method);
  Running(Running&& other) noexcept
      : method_(std::exchange(other.method_, nullptr)), begin_(other.begin_) {}
  /// Counts the call as UNKNOWN if `end` was not called, for want of memory.
  ~Running();

  /// Counts the end of the call with gRPC's status code. Call it once.
  void end(int code) noexcept;

 private:
  using Clock = std::chrono::steady_clock;

  Method* method_ = nullptr;
  Clock::time_point begin_;
};

}  // namespace stiefel::server
