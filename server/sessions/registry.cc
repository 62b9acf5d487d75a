#include "server/sessions/registry.h"

#include <iterator>

namespace stiefel::server {
namespace {

std::tuple<std::string_view, std::string_view> key_of(std::string_view principal,
                                                      std::string_view id) {
  return {principal, id};
}

}  // namespace

RegisteredSession::RegisteredSession(Principal owner, std::string id, Scene scene,
                                     std::optional<Choice> choice,
                                     std::shared_ptr<const Clock> clock, MemoryBudget& memory,
                                     Time create_time)
    : Session(std::move(scene), memory),
      owner_(std::move(owner)),
      id_(std::move(id)),
      choice_(std::move(choice)),
      clock_(std::move(clock)),
      create_time_(create_time) {
  touch();
}

SessionRef RegisteredSession::use() {
  ++uses_;
  touch();
  return {this, [session = shared_from_this()](RegisteredSession*) {
            session->touch();
            --session->uses_;
          }};
}

MemoryLease Tombstones::reserve(std::string_view name, MemoryBudget& memory) {
  constexpr std::size_t objects = 160;  // around the name
  try {
    return {memory, name.size() + objects};
  } catch (const MemoryExhausted&) {
    return {};
  }
}

void Tombstones::put(std::string name, Time now, MemoryLease memory) {
  if (const auto found = by_name_.find(name); found != by_name_.end()) drop(found->second);
  expire(now);
  if (!order_.empty() && (!memory || order_.size() == max_count)) drop(order_.begin());
  order_.push_back({std::move(name), now, std::move(memory)});
  by_name_.emplace(order_.back().name, std::prev(order_.end()));
}

void Tombstones::expire(Time now) {
  while (!order_.empty() && now - order_.front().deleted >= lifetime_) drop(order_.begin());
}

void Tombstones::drop(std::list<Tombstone>::iterator tombstone) {
  by_name_.erase(tombstone->name);
  order_.erase(tombstone);
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
    std::optional<Choice> choice, bool recreate, MemoryBudget* memory) {
  const auto fresh = std::make_shared<RegisteredSession>(
      principal, id, std::move(scene), std::move(choice), clock_, memory ? *memory : memory_);
  if (auto fault = fresh->overflow()) return std::unexpected(*std::move(fault));
  std::optional<Checkpoint> saved;
  if (!checkpoint.empty()) {
    auto decoded = decode_checkpoint(*fresh, checkpoint);
    if (!decoded) return std::unexpected(std::move(decoded.error()));
    saved = *std::move(decoded);
  }
  // Before the lock: taking memory may evict caches, which locks the registry too.
  if (saved) fresh->restore_checkpoint(saved->step, saved->saved);
  Key key{principal.name, id};
  std::unique_lock lock(mutex_);
  const auto found = sessions_.find(key);
  if (found != sessions_.end()) {
    if (found->second->identity() != fresh->identity())
      return std::unexpected(Conflict::other_scene);
    Created there{found->second->use(), false, found->second->pending_write_};
    lock.unlock();
    if (saved) there.session->restore_checkpoint(saved->step, std::move(saved->saved));
    return there;
  }
  if (recreate && has_tombstone(principal, id)) return std::unexpected(Conflict::deleted);
  if (sessions_.size() >= max_sessions_) return std::unexpected(Conflict::too_many);
  // Keeps the tombstone: it counts again if the session cannot be written, and expires by itself.
  const auto place = sessions_.emplace(std::move(key), fresh).first;
  try {
    fresh->pending_write_ = record({fresh});
  } catch (...) {
    sessions_.erase(place);
    throw;
  }
  return Created{fresh->use(), true, fresh->pending_write_};
}

SessionRef Registry::find(const Principal& principal, std::string_view id) const {
  const std::shared_lock lock(mutex_);
  const auto found = sessions_.find(key_of(principal.name, id));
  return found == sessions_.end() ? nullptr : found->second->use();
}

PendingWrite Registry::erase(const Principal& principal, std::string_view id,
                             MemoryBudget* memory) {
  std::shared_ptr<RegisteredSession> dropped;
  // Before the lock, since giving up caches locks the registry too.
  MemoryLease reserved = Tombstones::reserve(id, memory ? *memory : memory_);
  const std::lock_guard lock(mutex_);
  tombstones_of(principal).put(std::string(id), (*clock_)(), std::move(reserved));
  const auto found = sessions_.find(key_of(principal.name, id));
  if (found != sessions_.end()) dropped = take_out(found);
  return record({nullptr, principal, std::string(id), Time::clock::now() + idle_timeout_});
}

std::shared_ptr<RegisteredSession> Registry::take_out(Sessions::iterator place) {
  auto session = std::move(place->second);
  session->closed_ = true;
  sessions_.erase(place);
  return session;
}

void Registry::restore(std::shared_ptr<RegisteredSession> session) {
  const std::lock_guard lock(mutex_);
  Key key{session->owner().name, session->id()};
  sessions_.emplace(std::move(key), std::move(session));
}

void Registry::restore_deletion(const Principal& principal, std::string id, Time until,
                                MemoryBudget* memory) {
  using Duration = std::chrono::steady_clock::duration;
  const auto left = std::chrono::duration_cast<Duration>(until - Time::clock::now());
  MemoryLease reserved = Tombstones::reserve(id, memory ? *memory : memory_);
  const std::lock_guard lock(mutex_);
  const auto deleted = (*clock_)() - idle_timeout_ + std::min<Duration>(left, idle_timeout_);
  tombstones_of(principal).put(std::move(id), deleted, std::move(reserved));
}

void Registry::drop(const RegisteredSession& session) {
  std::shared_ptr<RegisteredSession> dropped;
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(key_of(session.owner().name, session.id()));
  if (found == sessions_.end() || found->second.get() != &session) return;
  dropped = take_out(found);
}

std::vector<std::shared_ptr<RegisteredSession>> Registry::with_new_states() const {
  const std::shared_lock lock(mutex_);
  std::vector<std::shared_ptr<RegisteredSession>> sessions;
  for (const auto& [key, session] : sessions_)
    if (session->has_new_state()) sessions.push_back(session);
  return sessions;
}

bool Registry::has_tombstone(const Principal& principal, std::string_view id) const {
  const auto of_one = tombstones_.find(principal.name);
  return of_one != tombstones_.end() && of_one->second.contains(id, (*clock_)());
}

bool Registry::deleted(const Principal& principal, std::string_view id) const {
  const std::shared_lock lock(mutex_);
  return has_tombstone(principal, id) && !sessions_.contains(key_of(principal.name, id));
}

std::vector<std::shared_ptr<const RegisteredSession>> Registry::page(const Principal& principal,
                                                                     std::string_view after,
                                                                     std::size_t count) const {
  const std::shared_lock lock(mutex_);
  std::vector<std::shared_ptr<const RegisteredSession>> sessions;
  for (auto it = sessions_.upper_bound(key_of(principal.name, after));
       it != sessions_.end() && std::get<0>(it->first) == principal.name && sessions.size() < count;
       ++it)
    sessions.push_back(it->second);
  return sessions;
}

std::size_t Registry::size() const {
  const std::shared_lock lock(mutex_);
  return sessions_.size();
}

std::size_t Registry::expire() {
  std::vector<std::shared_ptr<RegisteredSession>> dropped;
  const std::lock_guard lock(mutex_);
  for (auto& [principal, tombstones] : tombstones_) tombstones.expire((*clock_)());
  std::erase_if(tombstones_, [](const auto& of_one) { return of_one.second.size() == 0; });
  for (auto place = sessions_.begin(); place != sessions_.end();) {
    const RegisteredSession& session = *place->second;
    const auto next = std::next(place);
    if (!session.in_use() && session.idle_time() >= idle_timeout_) {
      record({nullptr, session.owner(), session.id()});
      dropped.push_back(take_out(place));
    }
    place = next;
  }
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
