#pragma once

#include <prometheus/collectable.h>

#include <chrono>
#include <string>
#include <vector>

#include "server/limits/memory_budget.h"
#include "server/scheduling/account.h"
#include "server/scheduling/scheduler.h"
#include "server/sessions/registry.h"

namespace stiefel::server {

/// What a server holds and does, read when it is asked for. The parts must outlive it.
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

  /// Sessions, work, memory, threads, build, and the process's own numbers by the names that
  /// Prometheus gives them.
  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const Parts parts_;
  const std::chrono::system_clock::time_point start_ = std::chrono::system_clock::now();
};

}  // namespace stiefel::server
