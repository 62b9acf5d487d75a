#include "server/sessions/store/store_writer.h"

#include <pthread.h>

#include <exception>
#include <new>
#include <utility>

namespace stiefel::server {

PendingWrite StoreWriter::submit(Change change, OnFault on_fault) {
  Waiting waiting{std::move(change), std::move(on_fault), {}};
  PendingWrite end = waiting.end.get_future().share();
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back(std::move(waiting));
  }
  wake_.notify_one();
  return end;
}

void StoreWriter::work(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "store");
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return !queue_.empty(); })) {
    auto changes = std::exchange(queue_, {});
    lock.unlock();
    const auto of_all = commit(changes);
    const bool repeats = of_all && of_all->kind != WriteFault::Kind::locked && changes.size() > 1;
    for (Waiting& one : changes) {
      auto fault = repeats ? commit({&one, 1}) : of_all;
      if (fault) one.on_fault(*fault);
      one.end.set_value(std::move(fault));
    }
    changes.clear();
    lock.lock();
  }
}

std::optional<WriteFault> StoreWriter::commit(std::span<Waiting> changes) try {
  try {
    store_.transact([&] {
      for (const Waiting& one : changes) one.change(store_);
    });
    transactions_.fetch_add(1, std::memory_order_relaxed);
    return std::nullopt;
  } catch (const StoreError& error) {
    return error.fault();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return WriteFault{WriteFault::Kind::damaged, error.what()};
  }
} catch (const std::bad_alloc&) {  // also where the fault has no memory for its text
  return WriteFault{WriteFault::Kind::out_of_memory, {}};
}

}  // namespace stiefel::server
