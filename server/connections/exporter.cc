#include "server/connections/exporter.h"

#include <chrono>
#include <ctime>
#include <exception>
#include <filesystem>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

#include "server/connections/listener.h"
#include "server/scheduling/memory_limit.h"
#include "server/sessions/identity.h"

namespace stiefel::server {
namespace {

using prometheus::MetricType;
using Families = std::vector<prometheus::MetricFamily>;

/// Returns a family of one value. Its help is one sentence.
prometheus::MetricFamily single(MetricType type, const char* name, const char* help, double value,
                                std::vector<prometheus::ClientMetric::Label> labels = {}) {
  prometheus::ClientMetric metric;
  metric.label = std::move(labels);
  (type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  return {name, help, type, {std::move(metric)}};
}

double open_descriptors() {
  std::error_code fault;
  const std::filesystem::directory_iterator all("/proc/self/fd", fault);
  return fault ? 0 : static_cast<double>(std::distance(begin(all), end(all)));
}

class Page final : public prometheus::Collectable {
 public:
  explicit Page(const Exporter::Parts& parts) : of_(parts) {}

  /// Returns none for want of memory: no exception may pass the C code of civetweb.
  Families Collect() const override {
    try {
      return collected();
    } catch (const std::exception&) {
      return {};
    }
  }

 private:
  Families collected() const {
    const auto gauge = [](const char* name, const char* help, auto value) {
      return single(MetricType::Gauge, name, help, static_cast<double>(value));
    };
    const auto counter = [](const char* name, const char* help, double value) {
      return single(MetricType::Counter, name, help, value);
    };
    Families all = of_.calls.Collect();
    for (auto& family : {
             gauge("stiefel_sessions", "Sessions that the server holds.", of_.registry.size()),
             gauge("stiefel_sessions_limit", "Largest number of sessions (--max-sessions).",
                   of_.registry.max_sessions()),
             counter("stiefel_computing_seconds_total",
                     "Time for which calls have computed, in seconds.",
                     std::chrono::duration<double>(of_.turns.computed()).count()),
             gauge("stiefel_calls_waiting", "Calls that wait for their turn to compute.",
                   of_.turns.waiting()),
             gauge("stiefel_threads", "Threads that compute.", of_.threads),
             gauge("stiefel_memory_bytes", "Bytes that sessions and calls hold.",
                   of_.memory.used()),
             gauge("stiefel_memory_limit_bytes", "Bytes that sessions and calls may hold.",
                   of_.memory.limit()),
             single(MetricType::Gauge, "stiefel_build_info", "The build; its value is 1.", 1,
                    {{"version", STIEFEL_VERSION}, {"numerics_id", numerics_id()}}),
             gauge("process_resident_memory_bytes", "Resident memory of the process.",
                   resident_bytes()),
             counter("process_cpu_seconds_total", "Processor time of the process, in seconds.",
                     static_cast<double>(std::clock()) / CLOCKS_PER_SEC),
             gauge("process_open_fds", "Open file descriptors.", open_descriptors()),
             gauge("process_start_time_seconds", "Start of the server, in seconds since 1970.",
                   std::chrono::duration<double>(start_.time_since_epoch()).count()),
         })
      all.push_back(family);
    return all;
  }

  const Exporter::Parts of_;
  const std::chrono::system_clock::time_point start_ = std::chrono::system_clock::now();
};

[[noreturn]] void cannot_serve(const std::string& address, const std::string& why) {
  throw std::runtime_error("cannot serve metrics on " + address + ": " + why);
}

}  // namespace

void check_exporter(const std::string& address, bool insecure) {
  if (const auto fault = address_fault(address)) cannot_serve(address, *fault);
  if (is_unix(address) || address.starts_with('['))
    cannot_serve(address, "must be host:port with a name or an IPv4 address");
  if (!insecure && is_exposed(address))
    cannot_serve(address, "other machines can reach it: give --insecure, and a network policy");
}

Exporter::Exporter(const std::string& address, bool insecure, const Parts& parts)
    : page_(std::make_shared<Page>(parts)) {
  check_exporter(address, insecure);
  try {
    // A silent connection holds one of the threads until the time for its request is over.
    exposer_ = std::make_unique<prometheus::Exposer>(std::vector<std::string>{
        "listening_ports", address, "num_threads", "4", "request_timeout_ms", "2000"});
  } catch (const std::exception& fault) {
    cannot_serve(address, fault.what());
  }
  exposer_->RegisterCollectable(page_);
  url_ = "http://" + address.substr(0, address.rfind(':') + 1) +
         std::to_string(exposer_->GetListeningPorts().front()) + "/metrics";
}

}  // namespace stiefel::server
