#pragma once

#include <grpcpp/server_context.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>

#include "server/calls/call_log.h"
#include "server/scheduling/account.h"
#include "server/scheduling/helpers.h"
#include "server/scheduling/memory_budget.h"
#include "server/scheduling/slice.h"
#include "server/scheduling/turns.h"
#include "server/sessions/registry.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel::server {

/// The phases of a server: serving, refusing (new work gets UNAVAILABLE), stopping (running work
/// ends at its next slice, with a checkpoint if it has one) and interrupting (also inside a slice).
/// Also counts the running calls, each until its reply is delivered.
class Lifecycle {
 public:
  bool refusing() const { return refusing_.load(std::memory_order_relaxed); }
  bool stopping() const { return stopping_.load(std::memory_order_relaxed); }
  std::stop_token stop_token() const { return stop_.get_token(); }
  void refuse() { refusing_ = true; }
  void stop() { stopping_ = true; }
  void interrupt() { stop_.request_stop(); }

  void enter() { ++running_; }
  void leave() {
    const std::lock_guard lock(mutex_);
    if (--running_ == 0) idle_.notify_all();
  }
  /// Waits at most `patience` for all running calls to end; returns whether they have.
  bool wait_idle(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return idle_.wait_for(lock, patience, [this] { return running_ == 0; });
  }

 private:
  std::atomic<bool> refusing_ = false, stopping_ = false;
  std::stop_source stop_;
  std::atomic<int> running_ = 0;
  std::mutex mutex_;
  std::condition_variable idle_;
};

/// Returns who calls, for tests; empty: the caller's token decides.
using Identify = std::function<Principal(const grpc::ServerContextBase&)>;

/// The objects that every call uses.
struct Host {
  Log log;
  /// The bytes that the whole process may take, and the budget of calls and sessions within them.
  const std::uint64_t memory_limit;
  MemoryBudget memory;
  Accounts accounts;
  Registry registry;
  Lifecycle lifecycle;
  Identify identify;
  /// Null if nobody reads metrics.
  std::unique_ptr<CallMetrics> metrics;
  /// The threads that compute at once.
  const int threads;
  Turns turns{threads};
  Helpers helpers{turns, threads - 1};
  std::atomic<std::uint32_t> open_calls = 0;
  v1::DescribeResponse description = {};
};

}  // namespace stiefel::server
