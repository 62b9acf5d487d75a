#pragma once

#include <prometheus/collectable.h>
#include <prometheus/exposer.h>

#include <memory>
#include <string>

#include "server/connections/metrics.h"
#include "server/scheduling/memory_budget.h"
#include "server/scheduling/turns.h"
#include "server/sessions/registry.h"

namespace stiefel::server {

/// Serves metrics over HTTP at /metrics, in Prometheus's text format, by prometheus-cpp: those of
/// calls, what the server holds and does, and those of the process under Prometheus's usual names.
class Exporter {
 public:
  /// What the metrics tell of; it must outlive the exporter.
  struct Parts {
    const CallMetrics& calls;
    const Registry& registry;
    const Turns& turns;
    const MemoryBudget& memory;
    int threads;
  };

  /// Listens on host:port; port 0 means a free one. Throws std::runtime_error, also for an address
  /// on which prometheus-cpp does not listen, a Unix socket or an IPv6 address, and for one that
  /// other machines can reach unless `insecure` permits that.
  Exporter(const std::string& address, bool insecure, const Parts& parts);

  /// The URL, "http://127.0.0.1:9464/metrics".
  const std::string& url() const { return url_; }

 private:
  const std::shared_ptr<prometheus::Collectable> page_;
  std::unique_ptr<prometheus::Exposer> exposer_;
  std::string url_;
};

/// Throws std::runtime_error where the constructor of Exporter would, but does not listen.
void check_exporter(const std::string& address, bool insecure);

}  // namespace stiefel::server
