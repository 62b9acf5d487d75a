#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <expected>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <thread>
#include <variant>
#include <vector>

#include "server/sessions/checkpoint_bytes.h"
#include "server/sessions/session.h"

namespace stiefel::server {

/// The sessions by their ids. Thread-safe.
class Registry {
 public:
  /// The caches of the sessions are given up for whoever takes memory of the budget.
  Registry(std::uint32_t max_sessions, std::chrono::milliseconds idle_timeout, Clock clock,
           MemoryBudget& memory = MemoryBudget::unlimited());
  ~Registry();

  struct Created {
    SessionLease session;
    bool created;
  };
  enum class Conflict { other_scene, too_many };
  using CreateError = std::variant<Conflict, CheckpointRefusal, Overflow>;

  /// A new session, with what `checkpoint` holds in its cache unless that is empty; or the one of
  /// that id, if its scene is the same. The checkpoint is checked in any case, and that the fields
  /// at step 0 are finite numbers: no other is ever sent. Throws MemoryExhausted.
  std::expected<Created, CreateError> create(const std::string& id, Scene scene,
                                             std::string_view checkpoint,
                                             Resolution resolution = {});
  std::optional<SessionLease> find(std::string_view id) const;
  /// False if there was none.
  bool erase(std::string_view id);
  /// At most `count` in the order of their ids, the first one after `id`. Looking renews nothing.
  std::vector<std::shared_ptr<const Session>> page(std::string_view after, std::size_t count) const;
  std::size_t size() const;

  /// Drops the sessions that had no call for the idle timeout; returns their number.
  std::size_t expire();
  /// The time at which the session expires without further calls.
  std::chrono::system_clock::time_point expire_time(const Session& session) const;

  /// Gives up about so many bytes of caches, of the sessions first that were not used for longest.
  void shed(std::uint64_t bytes) const;

  std::uint32_t max_sessions() const { return max_sessions_; }
  std::chrono::milliseconds idle_timeout() const { return idle_timeout_; }

 private:
  const std::uint32_t max_sessions_;
  const std::chrono::milliseconds idle_timeout_;
  const std::shared_ptr<const Clock> clock_;
  MemoryBudget& memory_;
  mutable std::shared_mutex mutex_;
  std::map<std::string, std::shared_ptr<Session>, std::less<>> sessions_;
};

/// The thread that calls `Registry::expire` a few times in every idle timeout.
class Sweeper {
 public:
  Sweeper(Registry& registry, std::function<void(std::size_t dropped)> report);

 private:
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

}  // namespace stiefel::server
