#include "server/connections/metrics.h"

#include <absl/status/status.h>

#include <exception>

namespace stiefel::server {
namespace {

constexpr int codes = 17;
/// The reasons that are reported as 0 from the start.
constexpr const char* usual_reasons[]{"INTERNAL_ERROR",    "MEMORY_LIMIT",     "OUT_OF_MEMORY",
                                      "SHUTTING_DOWN",     "STORE_DAMAGED",    "STORE_FULL",
                                      "STORE_UNAVAILABLE", "TOO_MANY_SESSIONS"};

/// Upper bounds in seconds, from a Step by a closed form to a stream of minutes.
const prometheus::Histogram::BucketBoundaries bounds{1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3,
                                                     5e-3, 0.01, 0.02, 0.05, 0.1,  0.2,  0.5,  1,
                                                     2,    5,    10,   30,   100,  300};

}  // namespace

std::string code_name(int code) {
  // The canonical codes are gRPC's, with the same numbers.
  return absl::StatusCodeToString(static_cast<absl::StatusCode>(code));
}

CallMetrics::CallMetrics(const std::vector<std::string>& methods)
    : calls_(prometheus::BuildCounter()
                 .Name("stiefel_calls_total")
                 .Help("Calls that have ended, by method and status code.")
                 .Register(registry_)),
      refusals_(prometheus::BuildCounter()
                    .Name("stiefel_refusals_total")
                    .Help("Errors told to callers, those inside a Drive included, by reason and, "
                          "where a limit is exceeded, by limit.")
                    .Register(registry_)),
      running_(prometheus::BuildGauge()
                   .Name("stiefel_calls_running")
                   .Help("Calls that have begun and not ended, by method.")
                   .Register(registry_)),
      seconds_(prometheus::BuildHistogram()
                   .Name("stiefel_call_seconds")
                   .Help("Seconds from the arrival of a call at the service to its end, by method.")
                   .Register(registry_)) {
  for (const std::string& method : methods) {
    running_.Add({{"method", method}});
    seconds_.Add({{"method", method}}, bounds);
    for (int code = 0; code < codes; ++code)
      calls_.Add({{"method", method}, {"code", code_name(code)}});
  }
  for (const char* reason : usual_reasons) refusals_.Add({{"reason", reason}});
}

void CallMetrics::refused(const std::string& reason, const std::string& limit) {
  prometheus::Labels labels{{"reason", reason}};
  if (!limit.empty()) labels.emplace("limit", limit);
  refusals_.Add(labels).Increment();
}

void CallMetrics::end(const char* method, int code, double seconds) noexcept {
  try {
    running_.Add({{"method", method}}).Decrement();
    calls_.Add({{"method", method}, {"code", code_name(code)}}).Increment();
    seconds_.Add({{"method", method}}, bounds).Observe(seconds);
  } catch (const std::exception&) {  // no memory
  }
}

}  // namespace stiefel::server
