#include "server/sessions/registry.h"

#include <algorithm>
#include <utility>

namespace stiefel::server {

Registry::Registry(std::uint32_t max_sessions, std::chrono::milliseconds idle_timeout, Clock clock,
                   MemoryBudget& memory)
    : max_sessions_(max_sessions),
      idle_timeout_(idle_timeout),
      clock_(std::make_shared<const Clock>(clock ? std::move(clock)
                                                 : Clock(&std::chrono::steady_clock::now))),
      memory_(memory) {
  memory_.reclaim_with([this](std::uint64_t bytes) { shed(bytes); });
}

Registry::~Registry() { memory_.reclaim_with({}); }

std::expected<Registry::Created, Registry::CreateError> Registry::create(
    const std::string& id, Scene scene, std::string_view checkpoint, Resolution resolution) {
  const auto fresh =
      std::make_shared<Session>(id, std::move(scene), clock_, std::move(resolution), memory_);
  if (auto fault = fresh->overflow()) return std::unexpected(*std::move(fault));
  if (!checkpoint.empty()) {
    auto decoded = decode_checkpoint(*fresh, checkpoint);
    if (!decoded) return std::unexpected(std::move(decoded.error()));
    fresh->adopt(decoded->step, std::move(decoded->saved));
  }
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(id);
  if (found != sessions_.end()) {
    if (found->second->identity() != fresh->identity())
      return std::unexpected(Conflict::other_scene);
    return Created{SessionLease(found->second), false};
  }
  if (sessions_.size() >= max_sessions_) return std::unexpected(Conflict::too_many);
  sessions_.emplace(id, fresh);
  return Created{SessionLease(fresh), true};
}

std::optional<SessionLease> Registry::find(std::string_view id) const {
  const std::shared_lock lock(mutex_);
  const auto found = sessions_.find(id);
  if (found == sessions_.end()) return std::nullopt;
  return SessionLease(found->second);
}

bool Registry::erase(std::string_view id) {
  std::shared_ptr<Session> dropped;
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(id);
  if (found == sessions_.end()) return false;
  dropped = std::move(found->second);
  dropped->close();
  sessions_.erase(found);
  return true;
}

std::vector<std::shared_ptr<const Session>> Registry::page(std::string_view after,
                                                           std::size_t count) const {
  const std::shared_lock lock(mutex_);
  std::vector<std::shared_ptr<const Session>> sessions;
  for (auto it = sessions_.upper_bound(after); it != sessions_.end() && sessions.size() < count;
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
  std::erase_if(sessions_, [&](auto& entry) {
    Session& session = *entry.second;
    if (session.in_use() || session.idle_time() < idle_timeout_) return false;
    session.close();
    dropped.push_back(entry.second);
    return true;
  });
  return dropped.size();
}

void Registry::shed(std::uint64_t bytes) const {
  struct Cache {
    std::chrono::steady_clock::duration idle;
    std::uint64_t bytes;
    std::shared_ptr<Session> session;
  };
  std::vector<Cache> caches;
  {
    const std::shared_lock lock(mutex_);
    for (const auto& [id, session] : sessions_)
      if (const std::uint64_t cached = session->cached_bytes(); cached > 0)
        caches.push_back({session->idle_time(), cached, session});
  }
  std::ranges::stable_sort(caches, std::greater(), &Cache::idle);
  for (const Cache& cache : caches) {
    cache.session->shed();
    if (cache.bytes >= bytes) return;
    bytes -= cache.bytes;
  }
}

std::chrono::system_clock::time_point Registry::expire_time(const Session& session) const {
  return std::chrono::system_clock::now() +
         std::chrono::duration_cast<std::chrono::system_clock::duration>(idle_timeout_ -
                                                                         session.idle_time());
}

Sweeper::Sweeper(Registry& registry, std::function<void(std::size_t)> report)
    : thread_([this, &registry, report = std::move(report)](std::stop_token stop) {
        const auto pause = std::clamp<std::chrono::milliseconds>(
            registry.idle_timeout() / 4, std::chrono::milliseconds(10), std::chrono::minutes(1));
        std::unique_lock lock(mutex_);
        while (!wake_.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); })) {
          if (const std::size_t dropped = registry.expire()) report(dropped);
        }
      }) {}

}  // namespace stiefel::server
