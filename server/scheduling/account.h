#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <shared_mutex>
#include <string>
#include <unordered_map>

#include "server/scheduling/quota.h"
#include "server/scheduling/run_queue.h"
#include "server/sessions/principal.h"

namespace stiefel::server {

/// The time that work rates go by: the steady clock, or a test's.
using WorkClock = std::function<WorkRate::Time()>;

/// What a principal has in use, beside its quota. Thread-safe.
class Account {
 public:
  Account(Principal principal, const Quota& quota, const WorkClock& clock)
      : principal_(std::move(principal)),
        quota_(quota),
        clock_(clock),
        rate_(quota.work_a_second),
        share_(&rate_) {}
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

  /// A session's place; it is given back when the last copy goes.
  using Seat = std::shared_ptr<void>;
  struct Seated {
    Seat seat;                       // none if refused
    std::optional<Refusal> refusal;  // one if the principal has as many sessions as it may
  };
  Seated seat_session();

 private:
  friend class Ticket;
  friend class Accounts;

  const Principal principal_;
  const Quota quota_;
  const WorkClock& clock_;
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
  explicit Accounts(const Quota& quota, WorkClock clock = {});

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
  Account everybody_;  // of the principal without a name: found without a lock
  mutable std::shared_mutex mutex_;
  std::unordered_map<std::string, std::unique_ptr<Account>> named_;  // guarded by mutex_
};

}  // namespace stiefel::server
