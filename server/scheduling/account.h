#pragma once

#include <algorithm>
#include <atomic>
#include <expected>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <semaphore>
#include <thread>

#include "server/scheduling/memory_budget.h"
#include "server/scheduling/principal.h"
#include "server/scheduling/turns.h"

namespace stiefel::server {

/// Gives up about `bytes` bytes of the principal's caches.
using ReclaimOf = std::function<void(const Principal&, std::uint64_t bytes)>;

/// Counts what a principal uses, and refuses what would exceed its quota. Thread-safe.
class Account {
 public:
  /// `memory` is the budget of the whole server. It and `reclaim` must outlive the account.
  Account(Principal principal, const Quota& quota, MemoryBudget& memory, const ReclaimOf& reclaim);
  Account(const Account&) = delete;
  Account& operator=(const Account&) = delete;

  const Principal& principal() const { return principal_; }
  /// The time for which one call may compute.
  Turns::Time most_time() const;
  /// The principal's share of the places in which calls compute.
  Turns::Share& share() { return share_; }

  /// Counts a call of the principal, and in `all` the calls of all principals. If there are too
  /// many, returns the reason and counts nothing.
  std::optional<Refusal> enter_call(std::atomic<std::uint32_t>& all);
  void leave_call(std::atomic<std::uint32_t>& all);

  /// The budget for the principal's sessions and calls: a part of the server's memory, or all of it
  /// without a quota. Bytes beyond the part throw MemoryExhausted with `part()` "principal_memory".
  MemoryBudget& memory() { return memory_.limit() > 0 ? memory_ : whole_memory_; }
  MemoryBudget& whole_memory() { return whole_memory_; }

  /// A place in the account, given back when the last copy is destroyed.
  using Place = std::shared_ptr<void>;
  /// Takes a session's place, or returns why there is none; for a restored session even beyond the
  /// quota.
  std::expected<Place, Refusal> admit_session(bool restored = false);
  /// Takes a place among the principal's streams that hold a large simulation at once, one a core
  /// and at least two. Returns null if there is none within `patience`.
  Place large_stream(std::chrono::milliseconds patience);

 private:
  const Principal principal_;
  const Quota quota_;
  MemoryBudget& whole_memory_;
  MemoryBudget memory_;
  Turns::Share share_;
  std::counting_semaphore<> large_streams_{
      std::max(2, static_cast<int>(std::thread::hardware_concurrency()))};
  std::atomic<std::uint32_t> sessions_ = 0, calls_ = 0;
};

/// The accounts of all principals, which live as long as this object, one for each principal.
/// Thread-safe.
class Accounts {
 public:
  /// `memory` is the budget of the whole server and must outlive this object. `reclaim` is called
  /// for a principal whose part of the memory is used up.
  explicit Accounts(const Quota& quota, MemoryBudget& memory = MemoryBudget::unlimited(),
                    ReclaimOf reclaim = {});

  /// Returns the principal's account, made at the first call.
  Account& of(const Principal& principal);

 private:
  const Quota quota_;
  MemoryBudget& memory_;
  const ReclaimOf reclaim_;
  std::mutex mutex_;
  std::map<Principal, std::unique_ptr<Account>> accounts_;  // guarded by mutex_
};

}  // namespace stiefel::server
