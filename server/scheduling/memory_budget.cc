#include "server/scheduling/memory_budget.h"

#include <algorithm>

namespace stiefel::server {

MemoryExhausted::MemoryExhausted(std::uint64_t bytes, std::uint64_t free, std::uint64_t limit,
                                 const char* part)
    : bytes_(bytes), free_(free), limit_(limit), part_(part) {
  text_ = "the call needs " + std::to_string(bytes_) + " bytes of memory; " +
          std::to_string(free_) + " of " + std::to_string(limit_) + " are free";
}

bool MemoryBudget::try_take(std::uint64_t bytes) noexcept {
  if (!try_take_here(bytes)) return false;
  if (!whole_ || whole_->try_take(bytes)) return true;
  used_.fetch_sub(bytes, std::memory_order_relaxed);
  return false;
}

bool MemoryBudget::try_take_here(std::uint64_t bytes) noexcept {
  std::uint64_t used = used_.load(std::memory_order_relaxed);
  do {
    if (used > limit_ || bytes > limit_ - used) return false;
  } while (!used_.compare_exchange_weak(used, used + bytes, std::memory_order_relaxed));
  return true;
}

void MemoryBudget::take(std::uint64_t bytes, std::uint64_t held) {
  take_here(bytes, held);
  if (!whole_) return;
  try {
    whole_->take(bytes, held);
  } catch (...) {
    used_.fetch_sub(bytes, std::memory_order_relaxed);
    throw;
  }
}

void MemoryBudget::take_here(std::uint64_t bytes, std::uint64_t held) {
  if (try_take_here(bytes)) return;
  if (bytes <= limit_) {
    const std::lock_guard lock(reclaiming_);
    if (try_take_here(bytes)) return;  // another call has made room
    // Reclaims more than is needed, so that the next calls need not reclaim again.
    if (reclaim_) reclaim_(std::max(bytes, limit_ / 16));
    if (try_take_here(bytes)) return;
  }
  if (excess_allowed_) {
    used_.fetch_add(bytes, std::memory_order_relaxed);
    return;
  }
  throw MemoryExhausted(held + bytes, held + limit_ - std::min(used(), limit_), limit_, name_);
}

MemoryLease MemoryLease::if_it_fits(MemoryBudget& budget, std::uint64_t bytes) {
  MemoryLease lease;
  if (!budget.try_take(bytes)) return lease;
  lease.budget_ = &budget;
  lease.bytes_ = bytes;
  return lease;
}

MemoryLease& MemoryLease::operator=(MemoryLease&& other) noexcept {
  if (this == &other) return *this;
  shrink(bytes());
  budget_ = std::exchange(other.budget_, nullptr);
  bytes_ = other.bytes_.exchange(0);
  return *this;
}

void MemoryLease::grow(std::uint64_t more, std::uint64_t held) {
  budget_->take(more, held);
  bytes_.fetch_add(more, std::memory_order_relaxed);
}

void MemoryLease::shrink(std::uint64_t less) noexcept {
  std::uint64_t held = bytes_.load(std::memory_order_relaxed);
  while (
      !bytes_.compare_exchange_weak(held, held - std::min(held, less), std::memory_order_relaxed)) {
  }
  if (budget_ && less > 0) budget_->give_back(std::min(held, less));
}

}  // namespace stiefel::server
