#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <thread>
#include <vector>

#include "server/sessions/pending_write.h"
#include "server/sessions/store/store.h"

namespace stiefel::server {

/// Makes changes of a store, in their order, on a thread of its own. The changes that arrive during
/// one transaction form the next, so that many calls share one wait for the disk. A transaction
/// that fails is repeated change by change, so that only what does not fit fails; unless another
/// program holds the file's lock: then all of its changes fail.
class StoreWriter {
 public:
  using Change = std::function<void(Store&)>;
  using OnFault = std::function<void(const WriteFault&)>;

  /// The store must outlive the writer.
  explicit StoreWriter(Store& store) : store_(store) {}
  /// Makes all waiting changes.
  ~StoreWriter() = default;

  /// Queues a change and returns at once. `on_fault` is called on the writer's thread before the
  /// write ends with a fault; neither may throw but the change.
  PendingWrite submit(Change change, OnFault on_fault);

  /// The number of transactions that were committed. Thread-safe.
  std::uint64_t transactions() const { return transactions_.load(std::memory_order_relaxed); }

 private:
  struct Waiting {
    Change change;
    OnFault on_fault;
    std::promise<std::optional<WriteFault>> end;
  };

  void work(const std::stop_token& stop);
  std::optional<WriteFault> commit(std::span<Waiting> changes);

  Store& store_;
  std::atomic<std::uint64_t> transactions_ = 0;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::vector<Waiting> queue_;  // guarded by mutex_
  std::jthread thread_{[this](const std::stop_token& stop) { work(stop); }};
};

}  // namespace stiefel::server
