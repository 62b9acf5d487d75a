#pragma once

#include <prometheus/collectable.h>

#include <chrono>
#include <string>
#include <vector>

#include "server/scheduling/account.h"
#include "server/scheduling/memory_budget.h"
#include "server/scheduling/scheduler.h"
#include "server/sessions/registry.h"

namespace stiefel::server {

/// Metrics of what a server holds and does, read on request. The parts must outlive this object.
class ServerMetrics final : public prometheus::Collectable {
 public:
  struct Parts {
    const Registry& registry;
    const Scheduler& scheduler;
    const Accounts& accounts;
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
