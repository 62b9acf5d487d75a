#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>

#include "server/admission/log.h"
#include "server/admission/principal.h"
#include "server/limits/memory_budget.h"
#include "server/scheduling/account.h"
#include "server/scheduling/pool.h"
#include "server/scheduling/slice.h"
#include "server/sessions/registry.h"

namespace stiefel::server {

/// From serving over refusing (new work gets UNAVAILABLE) to stopping (what runs ends at its next
/// slice), and the count of what runs: calls that compute, until their reply is delivered.
class Lifecycle {
 public:
  bool refusing() const { return refusing_.load(std::memory_order_relaxed); }
  bool stopping() const { return stop_.stop_requested(); }
  std::stop_token stop_token() const { return stop_.get_token(); }
  void refuse() { refusing_ = true; }
  void stop() { stop_.request_stop(); }

  void enter() { ++running_; }
  void leave() {
    const std::lock_guard lock(mutex_);
    if (--running_ == 0) idle_.notify_all();
  }
  /// True when nothing runs any more.
  bool wait_idle(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return idle_.wait_for(lock, patience, [this] { return running_ == 0; });
  }

 private:
  std::atomic<bool> refusing_ = false;
  std::stop_source stop_;
  std::atomic<int> running_ = 0;
  std::mutex mutex_;
  std::condition_variable idle_;
};

/// What a call's stop callback does.
struct RequestStop {
  std::stop_source stop;
  void operator()() { stop.request_stop(); }
};

/// Who calls: `principal_of`, or what a test says.
using Identify = std::function<Principal(const grpc::CallbackServerContext&)>;

/// What every call works with. The scheduler comes last: it is gone before anything its jobs use.
struct Host {
  Log log;
  /// What the whole process may take, and the part of it that calls and sessions may.
  const std::uint64_t memory_limit;
  MemoryBudget memory;
  Accounts accounts;
  Registry registry;
  Lifecycle lifecycle;
  Identify identify;
  /// Null: nobody reads any.
  std::shared_ptr<Metrics> metrics;
  Scheduler scheduler;
  /// For steps that are short, for work that has slices, and for work that has none or long ones.
  Pool steps{scheduler, JobKind::brief};
  Pool pool{scheduler, JobKind::sliced};
  Pool searches{scheduler, JobKind::whole};

  /// Where steps of that cost, in nanoseconds, belong: a slice is at least one of them.
  Pool& pool_for(double step_cost) {
    switch (kind_of_steps(step_cost)) {
      case JobKind::brief:
        return steps;
      case JobKind::sliced:
        return pool;
      case JobKind::whole:
        break;
    }
    return searches;
  }
};

}  // namespace stiefel::server
