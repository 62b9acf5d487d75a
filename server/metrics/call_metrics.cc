#include "server/metrics/call_metrics.h"

#include <algorithm>

#include "server/metrics/family.h"

namespace stiefel::server {
namespace {

constexpr std::array names{
    "OK",        "CANCELLED",      "UNKNOWN",           "INVALID_ARGUMENT",   "DEADLINE_EXCEEDED",
    "NOT_FOUND", "ALREADY_EXISTS", "PERMISSION_DENIED", "RESOURCE_EXHAUSTED", "FAILED_PRECONDITION",
    "ABORTED",   "OUT_OF_RANGE",   "UNIMPLEMENTED",     "INTERNAL",           "UNAVAILABLE",
    "DATA_LOSS", "UNAUTHENTICATED"};
static_assert(names.size() == CallMetrics::codes);

/// The codes with which the service answers. They are reported as 0 from the start, because a rate
/// needs a value before the first event.
constexpr std::array usual{"OK",
                           "CANCELLED",
                           "INVALID_ARGUMENT",
                           "NOT_FOUND",
                           "ALREADY_EXISTS",
                           "RESOURCE_EXHAUSTED",
                           "FAILED_PRECONDITION",
                           "INTERNAL",
                           "UNAVAILABLE",
                           "UNAUTHENTICATED"};
/// The reasons that are reported as 0 from the start.
constexpr std::array usual_reasons{"INTERNAL_ERROR", "MEMORY_LIMIT",      "OUT_OF_MEMORY",
                                   "PRICE_REACHED",  "SHUTTING_DOWN",     "STORE_DAMAGED",
                                   "STORE_FULL",     "STORE_UNAVAILABLE", "TOO_MANY_SESSIONS"};

/// Upper bounds in seconds, from a Step that is answered inline to a stream of minutes.
const prometheus::Histogram::BucketBoundaries bounds{1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3,
                                                     5e-3, 0.01, 0.02, 0.05, 0.1,  0.2,  0.5,  1,
                                                     2,    5,    10,   30,   100,  300};
constexpr std::size_t unknown = 2;

}  // namespace

const char* code_name(int code) {
  return 0 <= code && code < CallMetrics::codes ? names[static_cast<std::size_t>(code)] : "UNKNOWN";
}

CallMetrics::Method::Method(std::string its_name) : name(std::move(its_name)), seconds(bounds) {}

CallMetrics::CallMetrics(const std::vector<std::string>& methods) {
  for (const std::string& method : methods) methods_.emplace_back(method);
  for (const char* reason : usual_reasons) refusals_[{reason, ""}] = 0;
}

CallMetrics::Method* CallMetrics::find(std::string_view name) {
  const auto found = std::ranges::find(methods_, name, &Method::name);
  return found == methods_.end() ? nullptr : &*found;
}

void CallMetrics::refused(const std::string& reason, const std::string& limit) {
  const std::lock_guard lock(mutex_);
  ++refusals_[{reason, limit}];
}

std::vector<prometheus::MetricFamily> CallMetrics::Collect() const {
  return {calls(), running(), seconds(), refusals()};
}

prometheus::MetricFamily CallMetrics::calls() const {
  auto all = family("stiefel_calls_total", "Calls that have ended, by method and status code.",
                    prometheus::MetricType::Counter);
  for (const Method& method : methods_) {
    for (std::size_t code = 0; code < codes; ++code) {
      const std::uint64_t count = method.ended[code].load(std::memory_order_relaxed);
      if (count > 0 || std::ranges::count(usual, std::string_view(names[code])) > 0)
        add_value(all, {{"method", method.name}, {"code", names[code]}},
                  static_cast<double>(count));
    }
  }
  return all;
}

prometheus::MetricFamily CallMetrics::running() const {
  auto all = family("stiefel_calls_running", "Calls that have begun and not ended, by method.",
                    prometheus::MetricType::Gauge);
  for (const Method& method : methods_) {
    // Reads `ended` first, so that the difference is never negative.
    std::uint64_t ended = 0;
    for (const auto& count : method.ended) ended += count.load(std::memory_order_acquire);
    const std::uint64_t begun = method.begun.load(std::memory_order_relaxed);
    add_value(all, {{"method", method.name}}, static_cast<double>(begun - ended));
  }
  return all;
}

prometheus::MetricFamily CallMetrics::seconds() const {
  auto all = family("stiefel_call_seconds",
                    "Seconds from the arrival of a call at the service to its end, by method.",
                    prometheus::MetricType::Histogram);
  for (const Method& method : methods_) {
    all.metric.push_back(method.seconds.Collect());
    all.metric.back().label = {{"method", method.name}};
  }
  return all;
}

prometheus::MetricFamily CallMetrics::refusals() const {
  auto all = family("stiefel_refusals_total",
                    "Errors told to callers, those inside a Drive included, by reason and, where "
                    "a limit is exceeded, by limit.",
                    prometheus::MetricType::Counter);
  const std::lock_guard lock(mutex_);
  for (const auto& [why, count] : refusals_) {
    Labels labels{{"reason", why.first}};
    if (!why.second.empty()) labels.push_back({"limit", why.second});
    add_value(all, std::move(labels), static_cast<double>(count));
  }
  return all;
}

CallMetrics::Running::Running(CallMetrics* metrics, std::string_view method)
    : method_(metrics ? metrics->find(method) : nullptr) {
  if (!method_) return;
  method_->begun.fetch_add(1, std::memory_order_relaxed);
  begin_ = Clock::now();
}

CallMetrics::Running::~Running() { end(static_cast<int>(unknown)); }

void CallMetrics::Running::end(int code) noexcept {
  Method* const method = std::exchange(method_, nullptr);
  if (!method) return;
  method->ended[0 <= code && code < codes ? static_cast<std::size_t>(code) : unknown].fetch_add(
      1, std::memory_order_release);
  method->seconds.Observe(std::chrono::duration<double>(Clock::now() - begin_).count());
}

}  // namespace stiefel::server
