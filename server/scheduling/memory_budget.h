#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <string>
#include <utility>

namespace stiefel::server {

/// Thrown by MemoryBudget::take when the bytes do not fit even without caches.
class MemoryExhausted : public std::exception {
 public:
  MemoryExhausted(std::uint64_t bytes, std::uint64_t free, std::uint64_t limit,
                  const char* part = nullptr);

  const char* what() const noexcept override { return text_.c_str(); }
  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t free() const { return free_; }
  std::uint64_t limit() const { return limit_; }
  /// Whether the bytes would fit if nobody else held any.
  bool can_ever_fit() const { return bytes_ <= limit_; }
  /// The name of the exhausted part; null if the whole budget is exhausted.
  const char* part() const { return part_; }

 private:
  std::uint64_t bytes_, free_, limit_;
  const char* part_;
  std::string text_;
};

/// Counts the bytes that a server may hold and has taken. Bytes are taken by their predicted price,
/// before they are allocated. Thread-safe, and without a lock while the bytes fit.
class MemoryBudget {
 public:
  /// Gives up caches of about `bytes` bytes, whose `MemoryLease`s then give them back.
  using Reclaim = std::function<void(std::uint64_t bytes)>;

  explicit MemoryBudget(std::uint64_t limit) : limit_(limit) {}
  /// A part of `whole`, which must outlive it: its bytes are taken from both. `name`, a string
  /// literal, names the part in refusals.
  MemoryBudget(std::uint64_t limit, MemoryBudget& whole, const char* name)
      : limit_(limit), whole_(&whole), name_(name) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;
  /// Returns a budget into which everything fits.
  static MemoryBudget& unlimited() {
    static MemoryBudget all(std::numeric_limits<std::uint64_t>::max());
    return all;
  }

  std::uint64_t limit() const { return limit_; }
  std::uint64_t used() const { return used_.load(std::memory_order_relaxed); }

  /// Sets the function that gives up caches; empty once their holder is gone. `take` calls it
  /// without holding a lock that `try_take` or `give_back` needs.
  void reclaim_with(Reclaim reclaim) {
    const std::lock_guard lock(reclaiming_);
    reclaim_ = std::move(reclaim);
  }

  /// While `allowed`, `take` succeeds even beyond the limit, after it has given up the caches: for
  /// the sessions of a store, which a server must hold.
  void allow_excess(bool allowed) { excess_allowed_ = allowed; }

  /// Takes the bytes if they fit, without giving up caches; returns false if they do not.
  bool try_take(std::uint64_t bytes) noexcept;
  /// Takes the bytes, giving up caches if need be. Throws MemoryExhausted if they still do not fit.
  /// `held`: the bytes that the same call holds already, for the exception.
  void take(std::uint64_t bytes, std::uint64_t held = 0);
  void give_back(std::uint64_t bytes) noexcept {
    used_.fetch_sub(bytes, std::memory_order_relaxed);
    if (whole_) whole_->give_back(bytes);
  }

 private:
  bool try_take_here(std::uint64_t bytes) noexcept;
  void take_here(std::uint64_t bytes, std::uint64_t held);

  const std::uint64_t limit_;
  MemoryBudget* const whole_ = nullptr;
  const char* const name_ = nullptr;
  std::atomic<std::uint64_t> used_ = 0;
  std::atomic<bool> excess_allowed_ = false;
  std::mutex reclaiming_;
  Reclaim reclaim_;  // guarded by reclaiming_
};

/// Bytes taken from a budget, given back when the lease is destroyed. `grow` and `shrink` are
/// thread-safe, moves are not. A lease that is default-constructed or moved from has no budget.
class MemoryLease {
 public:
  MemoryLease() = default;
  /// Throws MemoryExhausted.
  MemoryLease(MemoryBudget& budget, std::uint64_t bytes) : budget_(&budget) { grow(bytes); }
  /// Returns a lease of the bytes if they fit, otherwise one without a budget, which converts to
  /// false. Gives up no cache.
  static MemoryLease if_it_fits(MemoryBudget& budget, std::uint64_t bytes);
  MemoryLease(MemoryLease&& other) noexcept
      : budget_(std::exchange(other.budget_, nullptr)), bytes_(other.bytes_.exchange(0)) {}
  MemoryLease& operator=(MemoryLease&& other) noexcept;
  ~MemoryLease() { shrink(bytes()); }

  std::uint64_t bytes() const { return bytes_.load(std::memory_order_relaxed); }
  explicit operator bool() const { return budget_ != nullptr; }
  /// Takes `more` bytes. Throws MemoryExhausted for `more`. The lease must have a budget.
  void grow(std::uint64_t more) { grow(more, 0); }
  /// Grows to at least `bytes` bytes. Throws MemoryExhausted for all of them.
  void grow_to(std::uint64_t bytes) {
    const std::uint64_t held = this->bytes();
    if (bytes > held) grow(bytes - held, held);
  }
  /// Gives back `less` bytes, at most those held.
  void shrink(std::uint64_t less) noexcept;

 private:
  void grow(std::uint64_t more, std::uint64_t held);

  MemoryBudget* budget_ = nullptr;
  std::atomic<std::uint64_t> bytes_ = 0;
};

}  // namespace stiefel::server
