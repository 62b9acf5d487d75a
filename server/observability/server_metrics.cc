#include "server/observability/server_metrics.h"

#include <sys/resource.h>

#include <filesystem>
#include <iterator>

#include "server/observability/metrics.h"
#include "server/scheduling/failpoint.h"
#include "server/scheduling/memory_limit.h"
#include "server/sessions/identity.h"

namespace stiefel::server {
namespace {

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

std::vector<prometheus::MetricFamily> ServerMetrics::Collect() const {
  failpoint("metrics.collect");
  const auto gauge = [](const char* name, const char* help, double value) {
    return single(name, help, MetricType::Gauge, value);
  };
  const auto counter = [](const char* name, const char* help, double value) {
    return single(name, help, MetricType::Counter, value);
  };
  const Accounts::Use use = parts_.accounts.use();
  const double start = std::chrono::duration<double>(start_.time_since_epoch()).count();
  return {
      gauge("stiefel_sessions", "Sessions that the server holds.",
            static_cast<double>(parts_.registry.size())),
      gauge("stiefel_sessions_limit", "Largest number of sessions (--max-sessions).",
            parts_.registry.max_sessions()),
      counter("stiefel_work_done_total", "Work done for calls, in instructions.",
              parts_.scheduler.work_done() + static_cast<double>(use.paid)),
      gauge("stiefel_work_queued",
            "Work that waits for a thread, in instructions: what is left of the price of each "
            "call, at most 5e9.",
            static_cast<double>(parts_.scheduler.waiting_work())),
      gauge("stiefel_work_admitted",
            "The prices of all calls that run or wait, streams of slow readers included, in "
            "instructions.",
            static_cast<double>(use.admitted)),
      gauge("stiefel_threads", "Threads that compute.", parts_.scheduler.threads()),
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
