#include "server/scheduling/account.h"

#include <utility>

namespace stiefel::server {
namespace {

// The estimated times after which a refused caller may try again: calls end sooner than streams and
// sessions.
constexpr std::chrono::milliseconds until_a_call_ends{100}, until_a_stream_ends{1000},
    until_a_session_goes{1000};
std::optional<Refusal> enter(std::atomic<std::uint32_t>& count, std::uint32_t most,
                             const char* limit, std::chrono::milliseconds retry_after) {
  const std::uint32_t now = count.fetch_add(1, std::memory_order_relaxed) + 1;
  if (most == 0 || now <= most) return std::nullopt;
  count.fetch_sub(1, std::memory_order_relaxed);
  return Refusal{limit, static_cast<double>(most), static_cast<double>(now), retry_after};
}

}  // namespace

Account::Account(Principal principal, const Quota& quota, MemoryBudget& memory,
                 const ReclaimOf& reclaim)
    : principal_(std::move(principal)),
      quota_(quota),
      whole_memory_(memory),
      memory_(quota.memory.value_or(0), memory, "principal_memory") {
  if (reclaim)
    memory_.reclaim_with([this, &reclaim](std::uint64_t bytes) { reclaim(principal_, bytes); });
}

Turns::Time Account::most_time() const {
  using Seconds = std::chrono::duration<double>;
  return quota_.call_seconds > 0
             ? std::chrono::duration_cast<Turns::Time>(Seconds(quota_.call_seconds))
             : Turns::Time::max();
}

std::expected<Account::Place, Refusal> Account::admit_session(bool restored) {
  const std::uint32_t most = restored ? 0 : quota_.sessions.value_or(0);
  if (const auto refusal = enter(sessions_, most, "principal_sessions", until_a_session_goes))
    return std::unexpected(*refusal);
  const auto leave = [](std::atomic<std::uint32_t>* count) {
    count->fetch_sub(1, std::memory_order_relaxed);
  };
  return std::shared_ptr<std::atomic<std::uint32_t>>(&sessions_, leave);
}

Account::Place Account::large_stream(std::chrono::milliseconds patience) {
  if (!large_streams_.try_acquire_for(patience)) return nullptr;
  return Place(&large_streams_, [](std::counting_semaphore<>* places) { places->release(); });
}

std::optional<Refusal> Account::enter_call(std::atomic<std::uint32_t>& all) {
  if (auto refusal = enter(calls_, quota_.calls, "principal_calls", until_a_call_ends))
    return refusal;
  auto refusal = enter(all, most_calls, "calls", until_a_stream_ends);
  if (refusal) calls_.fetch_sub(1, std::memory_order_relaxed);
  return refusal;
}

void Account::leave_call(std::atomic<std::uint32_t>& all) {
  calls_.fetch_sub(1, std::memory_order_relaxed);
  all.fetch_sub(1, std::memory_order_relaxed);
}

Accounts::Accounts(const Quota& quota, MemoryBudget& memory, ReclaimOf reclaim)
    : quota_(quota), memory_(memory), reclaim_(std::move(reclaim)) {}

Account& Accounts::of(const Principal& principal) {
  const std::lock_guard lock(mutex_);
  auto& account = accounts_[principal];
  if (!account) account = std::make_unique<Account>(principal, quota_, memory_, reclaim_);
  return *account;
}

}  // namespace stiefel::server
