#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <string>

namespace stiefel::server {

/// Thrown by MemoryBudget::take: the bytes asked for do not fit, even after every cache was given
/// up.
class MemoryExhausted : public std::exception {
 public:
  MemoryExhausted(std::uint64_t bytes, std::uint64_t free, std::uint64_t limit,
                  const char* part = nullptr);

  const char* what() const noexcept override { return text_.c_str(); }
  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t free() const { return free_; }
  std::uint64_t limit() const { return limit_; }
  /// Whether the bytes fit when nobody else holds any.
  bool can_ever_fit() const { return bytes_ <= limit_; }
  /// The name of the part that is exhausted; null: the whole budget is.
  const char* part() const { return part_; }

 private:
  std::uint64_t bytes_, free_, limit_;
  const char* part_;
  std::string text_;
};

/// The bytes that a server may hold, and how many of them are taken. Bytes are taken before they
/// are allocated, by their price. Thread-safe, and without a lock while the bytes fit.
class MemoryBudget {
 public:
  /// Gives up caches of about so many bytes, through `MemoryLease`s.
  using Reclaim = std::function<void(std::uint64_t bytes)>;

  explicit MemoryBudget(std::uint64_t limit) : limit_(limit) {}
  /// A part of `whole`, which must outlive it: its bytes are taken from both. `name`: that of a
  /// literal, for refusals.
  MemoryBudget(std::uint64_t limit, MemoryBudget& whole, const char* name)
      : limit_(limit), whole_(&whole), name_(name) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;
  /// Everything fits.
  static MemoryBudget& unlimited();

  std::uint64_t limit() const { return limit_; }
  std::uint64_t used() const { return used_.load(std::memory_order_relaxed); }
  /// All bytes given back so far.
  std::uint64_t given_back() const { return given_back_.load(std::memory_order_relaxed); }

  /// Whoever holds caches; an empty function when it is gone. `take` calls it without any lock that
  /// `try_take` or `give_back` need.
  void reclaim_with(Reclaim reclaim);

  /// False if they do not fit.
  bool try_take(std::uint64_t bytes) noexcept;
  /// Throws MemoryExhausted if they do not fit after caches were given up.
  void take(std::uint64_t bytes);
  void give_back(std::uint64_t bytes) noexcept;

 private:
  bool try_take_here(std::uint64_t bytes) noexcept;
  void take_here(std::uint64_t bytes);

  const std::uint64_t limit_;
  MemoryBudget* const whole_ = nullptr;
  const char* const name_ = nullptr;
  std::atomic<std::uint64_t> used_ = 0, given_back_ = 0;
  std::mutex reclaiming_;
  Reclaim reclaim_;  // guarded by reclaiming_
};

/// Bytes of a budget, given back at the end of its life. `grow` and `shrink` are thread-safe, moves
/// are not. A lease of nothing has no budget.
class MemoryLease {
 public:
  MemoryLease() = default;
  /// Throws MemoryExhausted.
  MemoryLease(MemoryBudget& budget, std::uint64_t bytes) : budget_(&budget) { grow(bytes); }
  /// What fits or nothing: `held` says which. Gives up no cache.
  static MemoryLease if_it_fits(MemoryBudget& budget, std::uint64_t bytes);
  MemoryLease(MemoryLease&& other) noexcept
      : budget_(other.budget_), bytes_(other.bytes_.exchange(0)) {}
  MemoryLease& operator=(MemoryLease&& other) noexcept;
  ~MemoryLease() { shrink(bytes()); }

  std::uint64_t bytes() const { return bytes_.load(std::memory_order_relaxed); }
  explicit operator bool() const { return budget_ != nullptr; }
  /// Throws MemoryExhausted. The lease must have a budget.
  void grow(std::uint64_t more);
  /// To at least so many bytes. Throws MemoryExhausted.
  void grow_to(std::uint64_t bytes);
  /// By at most what it holds.
  void shrink(std::uint64_t less) noexcept;

 private:
  MemoryBudget* budget_ = nullptr;
  std::atomic<std::uint64_t> bytes_ = 0;
};

}  // namespace stiefel::server
