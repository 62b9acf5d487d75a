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

/// The name of one of gRPC's status codes, 0 to 16: "OK", "CANCELLED" ...
const char* code_name(int code);

/// Counts and times calls by method and status code, and counts errors by reason. A call costs two
/// atomic additions, two looks at the clock and one observation under the method's own lock.
/// Thread-safe.
class CallMetrics final : public prometheus::Collectable {
 public:
  static constexpr int codes = 17;

  /// Calls of other methods are not counted.
  explicit CallMetrics(const std::vector<std::string>& methods);

  class Running;

  /// An error that a caller was told. `limit`: the one that the request exceeds, or empty.
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

/// A call from its begin to its end.
class CallMetrics::Running {
 public:
  Running() = default;
  /// Null: nothing is counted.
  Running(CallMetrics* metrics, std::string_view method);
  Running(Running&& other) noexcept
      : method_(std::exchange(other.method_, nullptr)), begin_(other.begin_) {}
  /// A call that did not say how it ended, because there was no memory for it, counts as UNKNOWN.
  ~Running();

  /// Once, with gRPC's status code.
  void end(int code) noexcept;

 private:
  using Clock = std::chrono::steady_clock;

  Method* method_ = nullptr;
  Clock::time_point begin_;
};

}  // namespace stiefel::server
