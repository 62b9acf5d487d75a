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
/// The most for which a price counts in the sum of prices, which then cannot overflow: three days
/// of one thread.
constexpr double largest_price = 0x1p50;

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

Account::Admission Account::admit_session() {
  if (auto refusal =
          enter(sessions_, quota_.sessions.value_or(0), "principal_sessions", until_a_session_goes))
    return {nullptr, refusal};
  return {permit(), std::nullopt};
}

Account::SessionPermit Account::admit_restored_session() {
  sessions_.fetch_add(1, std::memory_order_relaxed);
  return permit();
}

Account::SessionPermit Account::permit() {
  const auto leave = [](std::atomic<std::uint32_t>* count) {
    count->fetch_sub(1, std::memory_order_relaxed);
  };
  return std::shared_ptr<std::atomic<std::uint32_t>>(&sessions_, leave);
}

Permit& Permit::operator=(Permit&& other) noexcept {
  if (this == &other) return *this;
  give_back();
  account_ = std::exchange(other.account_, nullptr);
  kind_ = other.kind_;
  price_ = other.price_;
  return *this;
}

std::optional<Refusal> Permit::take(Account& account, Kind kind, double price) {
  give_back();
  const Quota& quota = account.quota_;
  if (quota.call_work > 0 && price > quota.call_work)
    return Refusal{"call_work", quota.call_work, price, milliseconds(0)};
  const bool stream = kind == Kind::stream;
  auto& count = stream ? account.streams_ : account.calls_;
  if (auto refusal = stream ? enter(count, quota.streams, "principal_streams", until_a_stream_ends)
                            : enter(count, quota.calls, "principal_calls", until_a_call_ends))
    return refusal;
  account_ = &account;
  kind_ = kind;
  price_ = static_cast<std::uint64_t>(std::clamp(price, 0.0, largest_price));
  account.admitted_.fetch_add(price_, std::memory_order_relaxed);
  return std::nullopt;
}

void Permit::give_back() {
  Account* account = std::exchange(account_, nullptr);
  if (!account) return;
  (kind_ == Kind::stream ? account->streams_ : account->calls_)
      .fetch_sub(1, std::memory_order_relaxed);
  account->admitted_.fetch_sub(price_, std::memory_order_relaxed);
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

Accounts::Use Accounts::use() const {
  Use all;
  const auto add = [&all](const Account& account) {
    all.admitted += account.admitted_.load(std::memory_order_relaxed);
    all.paid += account.paid_.load(std::memory_order_relaxed);
  };
  add(everybody_);
  const std::shared_lock lock(mutex_);
  for (const auto& [name, account] : named_) add(*account);
  return all;
}

}  // namespace stiefel::server
