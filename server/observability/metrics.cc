#include "server/observability/metrics.h"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "server/scheduling/memory_limit.h"
#include "server/sessions/identity.h"

namespace stiefel::server {
namespace {

using Labels = std::vector<prometheus::ClientMetric::Label>;

/// Returns a family of one value. Its help is one sentence.
prometheus::MetricFamily single(std::string name, std::string help, prometheus::MetricType type,
                                double value, Labels labels = {}) {
  prometheus::ClientMetric metric;
  metric.label = std::move(labels);
  (type == prometheus::MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  return {std::move(name), std::move(help), type, {std::move(metric)}};
}

constexpr std::size_t length = 55;  // of a header of version 00

bool is_hex(std::string_view text) {
  return std::ranges::all_of(
      text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool is_id(std::string_view text) {
  return is_hex(text) && text.find_first_not_of('0') != std::string_view::npos;
}

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
constexpr std::array usual_reasons{"INTERNAL_ERROR",    "MEMORY_LIMIT",     "OUT_OF_MEMORY",
                                   "SHUTTING_DOWN",     "STORE_DAMAGED",    "STORE_FULL",
                                   "STORE_UNAVAILABLE", "TOO_MANY_SESSIONS"};

/// Upper bounds in seconds, from a Step that is answered inline to a stream of minutes.
const prometheus::Histogram::BucketBoundaries bounds{1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3,
                                                     5e-3, 0.01, 0.02, 0.05, 0.1,  0.2,  0.5,  1,
                                                     2,    5,    10,   30,   100,  300};
constexpr std::size_t unknown = 2;

using prometheus::MetricType;

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double open_descriptors() {
  std::error_code fault;
  const std::filesystem::directory_iterator all("/proc/self/fd", fault);
  return fault ? 0 : static_cast<double>(std::distance(begin(all), end(all)));
}

}  // namespace

std::string_view trace_id(std::string_view header) {
  if (header.size() < length) return {};
  const std::string_view version = header.substr(0, 2), trace = header.substr(3, 32),
                         parent = header.substr(36, 16), flags = header.substr(53, 2);
  const bool dashes = header[2] == '-' && header[35] == '-' && header[52] == '-';
  const bool end = header.size() == length || (version != "00" && header[length] == '-');
  const bool sound = dashes && end && is_hex(version) && version != "ff" && is_id(trace) &&
                     is_id(parent) && is_hex(flags);
  return sound ? trace : std::string_view();
}

const char* code_name(int code) {
  return 0 <= code && code < CallMetrics::codes ? names[static_cast<std::size_t>(code)] : "UNKNOWN";
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
                    .Register(registry_)) {
  auto& running = prometheus::BuildGauge()
                      .Name("stiefel_calls_running")
                      .Help("Calls that have begun and not ended, by method.")
                      .Register(registry_);
  auto& seconds =
      prometheus::BuildHistogram()
          .Name("stiefel_call_seconds")
          .Help("Seconds from the arrival of a call at the service to its end, by method.")
          .Register(registry_);
  for (const std::string& name : methods) {
    methods_.push_back(
        {name, running.Add({{"method", name}}), seconds.Add({{"method", name}}, bounds), {}});
    for (std::size_t code = 0; code < codes; ++code)
      if (std::ranges::count(usual, std::string_view(names[code])) > 0)
        methods_.back().ended[code] = &calls_.Add({{"method", name}, {"code", names[code]}});
  }
  for (const char* reason : usual_reasons) refusals_.Add({{"reason", reason}});
}

void CallMetrics::refused(const std::string& reason, const std::string& limit) {
  prometheus::Labels labels{{"reason", reason}};
  if (!limit.empty()) labels.emplace("limit", limit);
  refusals_.Add(labels).Increment();
}

CallMetrics::Running::Running(CallMetrics* metrics, std::string_view method) : metrics_(metrics) {
  if (!metrics) return;
  const auto found = std::ranges::find(metrics->methods_, method, &Method::name);
  if (found == metrics->methods_.end()) return;
  method_ = &*found;
  method_->running.Increment();
  begin_ = Clock::now();
}

CallMetrics::Running::~Running() { end(static_cast<int>(unknown)); }

void CallMetrics::Running::end(int code) noexcept {
  const Method* const method = std::exchange(method_, nullptr);
  if (!method) return;
  const std::size_t index = 0 <= code && code < codes ? static_cast<std::size_t>(code) : unknown;
  try {
    prometheus::Counter* const ended = method->ended[index];
    (ended ? *ended : metrics_->calls_.Add({{"method", method->name}, {"code", names[index]}}))
        .Increment();
  } catch (const std::exception&) {  // no memory for a first call with this code
  }
  method->seconds.Observe(std::chrono::duration<double>(Clock::now() - begin_).count());
  method->running.Decrement();
}

std::vector<prometheus::MetricFamily> OpenStreams::Collect() const {
  const Clock::rep now = Clock::now().time_since_epoch().count();
  Clock::duration longest{0};
  std::size_t open = 0, late = 0;
  {
    const std::lock_guard lock(mutex_);
    open = streams_.size();
    for (const Stream* stream : streams_) {
      const Clock::rep since = stream->since_.load(std::memory_order_relaxed);
      if (since == Stream::not_waiting) continue;
      const Clock::duration waits(now - since);
      late += waits > behind;
      longest = std::max(longest, waits);
    }
  }
  using prometheus::MetricType;
  return {single("stiefel_streams_open", "Calls that answer with a stream of messages.",
                 MetricType::Gauge, static_cast<double>(open)),
          single("stiefel_streams_behind",
                 "Streams whose message has waited for its reader for more than 0.1 s.",
                 MetricType::Gauge, static_cast<double>(late)),
          single("stiefel_stream_lag_seconds",
                 "The longest time that a stream's message waits for its reader now.",
                 MetricType::Gauge, std::chrono::duration<double>(longest).count())};
}

OpenStreams::Stream::Stream(OpenStreams& all) : all_(all) {
  const std::lock_guard lock(all_.mutex_);
  all_.streams_.insert(this);
}

std::vector<prometheus::MetricFamily> ServerMetrics::Collect() const {
  const auto gauge = [](const char* name, const char* help, double value) {
    return single(name, help, MetricType::Gauge, value);
  };
  const auto counter = [](const char* name, const char* help, double value) {
    return single(name, help, MetricType::Counter, value);
  };
  const double start = std::chrono::duration<double>(start_.time_since_epoch()).count();
  return {
      gauge("stiefel_sessions", "Sessions that the server holds.",
            static_cast<double>(parts_.registry.size())),
      gauge("stiefel_sessions_limit", "Largest number of sessions (--max-sessions).",
            parts_.registry.max_sessions()),
      counter("stiefel_computing_seconds_total", "Time for which calls have computed, in seconds.",
              std::chrono::duration<double>(parts_.turns.computed()).count()),
      gauge("stiefel_calls_waiting", "Calls that wait for their turn to compute.",
            static_cast<double>(parts_.turns.waiting())),
      gauge("stiefel_threads", "Threads that compute.", parts_.threads),
      gauge("stiefel_memory_bytes", "Bytes that sessions and calls hold.",
            static_cast<double>(parts_.memory.used())),
      gauge("stiefel_memory_limit_bytes", "Bytes that sessions and calls may hold.",
            static_cast<double>(parts_.memory.limit())),
      single("stiefel_build_info", "The build; its value is 1.", MetricType::Gauge, 1,
             {{"version", parts_.version}, {"numerics_id", numerics_id()}}),
      gauge("process_resident_memory_bytes", "Resident memory of the process.",
            static_cast<double>(resident_bytes())),
      counter("process_cpu_seconds_total", "Processor time of the process, in seconds.",
              processor_seconds()),
      gauge("process_open_fds", "Open file descriptors.", open_descriptors()),
      gauge("process_start_time_seconds", "Start of the server, in seconds since 1970.", start),
  };
}

}  // namespace stiefel::server
