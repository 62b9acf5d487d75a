#pragma once

#include <prometheus/collectable.h>
#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/metric_family.h>
#include <prometheus/registry.h>

#include <string>
#include <vector>

namespace stiefel::server {

/// Returns the name of a gRPC status code, 0 to 16: "OK", "CANCELLED" ...
std::string code_name(int code);

/// Counts and times calls by method and status code, and counts errors by reason. Thread-safe.
class CallMetrics final : public prometheus::Collectable {
 public:
  /// All codes of these methods are reported as 0 from the start, because a rate needs a value
  /// before the first event.
  explicit CallMetrics(const std::vector<std::string>& methods);

  /// Counts a call from here to `end`.
  void begin(const char* method) { running_.Add({{"method", method}}).Increment(); }
  /// Counts the end of a call with gRPC's status code, after so many seconds.
  void end(const char* method, int code, double seconds) noexcept;
  /// Counts an error that a caller was told. `limit` is the limit that the request exceeds, or
  /// empty.
  void refused(const std::string& reason, const std::string& limit);

  /// stiefel_calls_total, stiefel_calls_running, stiefel_call_seconds, stiefel_refusals_total.
  std::vector<prometheus::MetricFamily> Collect() const override { return registry_.Collect(); }

 private:
  prometheus::Registry registry_;
  prometheus::Family<prometheus::Counter>&calls_, &refusals_;
  prometheus::Family<prometheus::Gauge>& running_;
  prometheus::Family<prometheus::Histogram>& seconds_;
};

}  // namespace stiefel::server
