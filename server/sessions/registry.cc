#include "server/sessions/registry.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace stiefel::server {
namespace {

std::tuple<std::string_view, std::string_view> key_of(std::string_view principal,
                                                      std::string_view id) {
  return {principal, id};
}

}  // namespace

MemoryLease DeletedNames::lease(std::string_view name, MemoryBudget& memory) {
  try {
    return {memory, bytes(name)};
  } catch (const MemoryExhausted&) {
    return {};
  }
}

void DeletedNames::put(std::string name, Time now, MemoryLease memory) {
  remove(name);
  expire(now);
  const std::size_t before = bytes_, taken = bytes(name);
  while (!memory && !order_.empty() && bytes_ + taken > before) drop(order_.begin());
  bytes_ += taken;
  order_.push_back({std::move(name), now, std::move(memory)});
  by_name_.emplace(order_.back().name, std::prev(order_.end()));
  while (order_.size() > max_count || bytes_ > max_bytes) drop(order_.begin());
}

void DeletedNames::expire(Time now) {
  while (!order_.empty() && now - order_.front().deleted >= lifetime_) drop(order_.begin());
}

void DeletedNames::drop(std::list<Entry>::iterator entry) {
  bytes_ -= bytes(entry->name);
  by_name_.erase(entry->name);
  order_.erase(entry);
}

Registry::Registry(std::uint32_t max_sessions, std::chrono::milliseconds idle_timeout, Clock clock,
                   MemoryBudget& memory)
    : max_sessions_(max_sessions),
      idle_timeout_(idle_timeout),
      clock_(std::make_shared<const Clock>(clock ? std::move(clock)
                                                 : Clock(&std::chrono::steady_clock::now))),
      memory_(memory) {
  memory_.reclaim_with([this](std::uint64_t bytes) { evict(bytes); });
}

Registry::~Registry() { memory_.reclaim_with({}); }

std::expected<Registry::Created, Registry::CreateError> Registry::create(
    const Principal& principal, const std::string& id, Scene scene, std::string_view checkpoint,
    Resolution resolution, bool recreate, MemoryBudget* memory) {
  const auto fresh = std::make_shared<Session>(id, std::move(scene), clock_, std::move(resolution),
                                               memory ? *memory : memory_);
  if (auto fault = fresh->overflow()) return std::unexpected(*std::move(fault));
  std::optional<Checkpoint> saved;
  if (!checkpoint.empty()) {
    auto decoded = decode_checkpoint(*fresh, checkpoint);
    if (!decoded) return std::unexpected(std::move(decoded.error()));
    saved = *std::move(decoded);
  }
  // Adopts before it locks: taking memory may evict caches, which locks the registry too.
  if (saved) fresh->adopt(saved->step, saved->saved);
  Key key{principal.name, id};
  std::unique_lock lock(mutex_);
  const auto found = sessions_.find(key);
  if (found != sessions_.end()) {
    if (found->second->identity() != fresh->identity())
      return std::unexpected(Conflict::other_scene);
    Created there{SessionLease(found->second), false, found->second->pending_write()};
    lock.unlock();
    if (saved) there.session->adopt(saved->step, std::move(saved->saved));
    return there;
  }
  if (recreate && has_deleted_name(principal, id)) return std::unexpected(Conflict::deleted);
  if (sessions_.size() >= max_sessions_) return std::unexpected(Conflict::too_many);
  // Keeps the deleted name: it counts again if the session cannot be written, and expires by
  // itself.
  const auto place = sessions_.emplace(std::move(key), fresh).first;
  try {
    fresh->set_owner(principal);
    if (log_) {
      fresh->write_to(*log_);
      fresh->written_by(log_->put(fresh));
    }
  } catch (...) {
    sessions_.erase(place);
    throw;
  }
  return Created{SessionLease(fresh), true, fresh->pending_write()};
}

std::optional<SessionLease> Registry::find(const Principal& principal, std::string_view id) const {
  const std::shared_lock lock(mutex_);
  const auto found = sessions_.find(key_of(principal.name, id));
  if (found == sessions_.end()) return std::nullopt;
  return SessionLease(found->second);
}

Registry::Erased Registry::erase(const Principal& principal, std::string_view id,
                                 MemoryBudget* memory) {
  std::shared_ptr<Session> dropped;
  // Before the lock, since giving up caches locks the registry too.
  MemoryLease mark = DeletedNames::lease(id, memory ? *memory : memory_);
  const std::lock_guard lock(mutex_);
  deleted_names_of(principal).put(std::string(id), (*clock_)(), std::move(mark));
  std::shared_ptr<PendingWrite> pending_write;
  if (log_)
    pending_write = log_->mark_deleted(principal, std::string(id),
                                       WriteAheadLog::Time::clock::now() + idle_timeout_);
  const auto found = sessions_.find(key_of(principal.name, id));
  if (found == sessions_.end()) return {false, std::move(pending_write)};
  dropped = take_out(found);
  return {true, std::move(pending_write)};
}

std::shared_ptr<Session> Registry::take_out(Sessions::iterator place) {
  auto session = std::move(place->second);
  session->close();
  sessions_.erase(place);
  return session;
}

void Registry::mark_deleted(const Principal& principal, std::string id, WriteAheadLog::Time until,
                            MemoryBudget* memory) {
  using Duration = std::chrono::steady_clock::duration;
  const auto left = std::chrono::duration_cast<Duration>(until - WriteAheadLog::Time::clock::now());
  MemoryLease mark = DeletedNames::lease(id, memory ? *memory : memory_);
  const std::lock_guard lock(mutex_);
  const auto deleted = (*clock_)() - idle_timeout_ + std::min<Duration>(left, idle_timeout_);
  deleted_names_of(principal).put(std::move(id), deleted, std::move(mark));
}

void Registry::drop(const Session& session) {
  std::shared_ptr<Session> dropped;
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(key_of(session.owner().name, session.id()));
  if (found == sessions_.end() || found->second.get() != &session) return;
  dropped = take_out(found);
}

bool Registry::deleted(const Principal& principal, std::string_view id) const {
  const std::shared_lock lock(mutex_);
  return has_deleted_name(principal, id) && !sessions_.contains(key_of(principal.name, id));
}

std::vector<std::shared_ptr<const Session>> Registry::page(const Principal& principal,
                                                           std::string_view after,
                                                           std::size_t count) const {
  const std::shared_lock lock(mutex_);
  std::vector<std::shared_ptr<const Session>> sessions;
  for (auto it = sessions_.upper_bound(key_of(principal.name, after));
       it != sessions_.end() && std::get<0>(it->first) == principal.name && sessions.size() < count;
       ++it) {
    sessions.push_back(it->second);
  }
  return sessions;
}

std::size_t Registry::size() const {
  const std::shared_lock lock(mutex_);
  return sessions_.size();
}

std::size_t Registry::expire() {
  std::vector<std::shared_ptr<Session>> dropped;
  const std::lock_guard lock(mutex_);
  for (auto of_one = deleted_names_.begin(); of_one != deleted_names_.end();) {
    of_one->second.expire((*clock_)());
    of_one = of_one->second.size() == 0 ? deleted_names_.erase(of_one) : std::next(of_one);
  }
  std::erase_if(sessions_, [&](auto& entry) {
    Session& session = *entry.second;
    if (session.in_use() || session.idle_time() < idle_timeout_) return false;
    if (log_) log_->erase(session.owner(), session.id());
    session.close();
    dropped.push_back(entry.second);
    return true;
  });
  return dropped.size();
}

void Registry::evict(std::uint64_t bytes, const Principal* of) const {
  struct Cache {
    std::chrono::steady_clock::duration idle;
    std::uint64_t bytes;
    std::shared_ptr<Session> session;
  };
  std::vector<Cache> caches;
  {
    const std::shared_lock lock(mutex_);
    const auto first = of ? sessions_.lower_bound(key_of(of->name, {})) : sessions_.begin();
    for (auto it = first; it != sessions_.end() && (!of || std::get<0>(it->first) == of->name);
         ++it)
      if (const std::uint64_t cached = it->second->cached_bytes(); cached > 0)
        caches.push_back({it->second->idle_time(), cached, it->second});
  }
  std::ranges::stable_sort(caches, std::greater(), &Cache::idle);
  for (const Cache& cache : caches) {
    cache.session->evict();
    if (cache.bytes >= bytes) return;
    bytes -= cache.bytes;
  }
}

}  // namespace stiefel::server
