#include "server/scheduling/account.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace stiefel::server {
namespace {

using std::chrono::milliseconds;

// The estimated times after which a refused caller may try again: calls end sooner than streams and
// sessions.
constexpr milliseconds until_a_call_ends{100}, until_a_stream_ends{1000},
    until_a_session_goes{1000};
std::optional<Refusal> enter(std::atomic<std::uint32_t>& count, std::uint32_t most,
                             const char* limit, milliseconds retry_after) {
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

Account::Admission Account::admit_session() {
  if (auto refusal =
          enter(sessions_, quota_.sessions.value_or(0), "principal_sessions", until_a_session_goes))
    return {nullptr, refusal};
  return {slot(), std::nullopt};
}

Account::SessionSlot Account::admit_restored_session() {
  sessions_.fetch_add(1, std::memory_order_relaxed);
  return slot();
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

Account::SessionSlot Account::slot() {
  const auto leave = [](std::atomic<std::uint32_t>* count) {
    count->fetch_sub(1, std::memory_order_relaxed);
  };
  return std::shared_ptr<std::atomic<std::uint32_t>>(&sessions_, leave);
}

Accounts::Accounts(const Quota& quota, MemoryBudget& memory, ReclaimOf reclaim)
    : quota_(quota),
      memory_(memory),
      reclaim_(std::move(reclaim)),
      everybody_({}, quota_, memory_, reclaim_) {}

Account& Accounts::of(const Principal& principal) {
  if (principal.name.empty()) return everybody_;
  {
    const std::shared_lock lock(mutex_);
    const auto found = named_.find(principal.name);
    if (found != named_.end()) return *found->second;
  }
  const std::unique_lock lock(mutex_);
  auto& account = named_[principal.name];
  if (!account) account = std::make_unique<Account>(principal, quota_, memory_, reclaim_);
  return *account;
}

}  // namespace stiefel::server
