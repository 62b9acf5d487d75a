#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <shared_mutex>
#include <string>
#include <unordered_map>

#include "server/limits/memory_budget.h"
#include "server/scheduling/quota.h"
#include "server/scheduling/run_queue.h"
#include "server/sessions/principal.h"

namespace stiefel::server {

/// The time that work rates go by: the steady clock, or a test's.
using WorkClock = std::function<WorkRate::Time()>;

/// Gives up about so many bytes of a principal's caches.
using ReclaimOf = std::function<void(const Principal&, std::uint64_t bytes)>;

/// What a principal has in use, beside its quota. Thread-safe.
class Account {
 public:
  /// `memory`: of the whole server.
  Account(Principal principal, const Quota& quota, const WorkClock& clock, MemoryBudget& memory,
          const ReclaimOf& reclaim);
  Account(const Account&) = delete;
  Account& operator=(const Account&) = delete;

  const Principal& principal() const { return principal_; }
  /// Its part of the threads.
  Share& share() { return share_; }

  /// Why no call may begin now: the principal has done more work than its rate allows.
  std::optional<Refusal> overdrawn();
  /// Counts work, in instructions, that was not done as a job.
  void pay(double work) {
    paid_.fetch_add(static_cast<std::uint64_t>(work), std::memory_order_relaxed);
    if (rate_.limited()) rate_.spend(work, clock_());
  }

  /// Of the whole server's memory the part that its sessions and calls may take. What does not fit
  /// throws MemoryExhausted with the part `principal_memory`.
  MemoryBudget& memory() { return quota_.memory > 0 ? memory_ : whole_memory_; }
  MemoryBudget& whole_memory() { return whole_memory_; }

  /// A session's place; it is given back when the last copy goes.
  using Seat = std::shared_ptr<void>;
  struct Seated {
    Seat seat;                       // none if refused
    std::optional<Refusal> refusal;  // one if the principal has as many sessions as it may
  };
  Seated seat_session();
  /// For a session that is there already: beyond the quota too.
  Seat seat_restored_session();

 private:
  friend class Ticket;
  friend class Accounts;

  /// Of one that is counted.
  Seat seat();

  const Principal principal_;
  const Quota quota_;
  const WorkClock& clock_;
  MemoryBudget& whole_memory_;
  MemoryBudget memory_;
  WorkRate rate_;
  Share share_;
  std::atomic<std::uint32_t> sessions_ = 0, streams_ = 0, calls_ = 0;
  std::atomic<std::uint64_t> queued_ = 0;  // instructions
  std::atomic<std::uint64_t> paid_ = 0;    // instructions
};

/// A call's place in an account, given back when the ticket goes.
class Ticket {
 public:
  enum class Kind : std::uint8_t { call, stream };

  Ticket() = default;
  Ticket(Ticket&& other) noexcept { *this = std::move(other); }
  Ticket& operator=(Ticket&& other) noexcept;
  ~Ticket() { give_back(); }

  /// Takes a place for a call of that price, in instructions, or says why there is none; then the
  /// ticket stays empty.
  std::optional<Refusal> take(Account& account, Kind kind, double price);
  void give_back();

 private:
  Account* account_ = nullptr;
  Kind kind_ = Kind::call;
  std::uint64_t price_ = 0;
};

/// The accounts of all principals. An account stays as long as this object: there are as many as
/// there are principals. Thread-safe.
class Accounts {
 public:
  /// `memory`: of the whole server, which must outlive it. `reclaim`: for a principal whose part of
  /// it is used up.
  explicit Accounts(const Quota& quota, WorkClock clock = {},
                    MemoryBudget& memory = MemoryBudget::unlimited(), ReclaimOf reclaim = {});

  /// That of the principal, new the first time.
  Account& of(const Principal& principal);

  /// Of all principals together, in instructions.
  struct Use {
    std::uint64_t admitted = 0;  ///< the prices of the calls that run or wait
    std::uint64_t paid = 0;      ///< work that was not done as a job
  };
  Use use() const;

 private:
  const Quota quota_;
  const WorkClock clock_;
  MemoryBudget& memory_;
  const ReclaimOf reclaim_;
  Account everybody_;  // of the principal without a name: found without a lock
  mutable std::shared_mutex mutex_;
  std::unordered_map<std::string, std::unique_ptr<Account>> named_;  // guarded by mutex_
};

}  // namespace stiefel::server
