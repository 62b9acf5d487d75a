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
#include "server/sessions/principal.h"
#include "server/sessions/session.h"

namespace stiefel::server {

/// What a session is found by: two principals may use one id, and each has a session of its own.
struct SessionKey {
  std::string principal, id;
};

/// By principal, then by id.
struct SessionKeyLess {
  using is_transparent = void;
  struct View {
    std::string_view principal, id;
    View(std::string_view owner, std::string_view name) : principal(owner), id(name) {}
    View(const SessionKey& key) : principal(key.principal), id(key.id) {}
    auto operator<=>(const View&) const = default;
  };
  bool operator()(const View& a, const View& b) const { return a < b; }
};

/// The sessions by their principals and ids. Thread-safe.
class Registry {
 public:
  /// `keys`: of the checkpoints; those of the process if null.
  Registry(std::uint32_t max_sessions, std::chrono::milliseconds idle_timeout, Clock clock,
           std::shared_ptr<const CheckpointKeys> keys = nullptr);

  struct Created {
    SessionLease session;
    bool created;
    bool checkpoint_ignored = false;  ///< another server's key signed it: CheckpointFault::foreign
  };
  enum class Conflict { other_scene, too_many };
  using CreateError = std::variant<Conflict, CheckpointRefusal, Overflow>;

  /// A new session, with what `checkpoint` holds in its cache unless that is empty; or the one of
  /// that id, if its scene is the same. The checkpoint is checked in any case, and that the fields
  /// at step 0 are finite numbers: no other is ever sent. A checkpoint that another server signed
  /// is ignored.
  std::expected<Created, CreateError> create(const Principal& principal, const std::string& id,
                                             Scene scene, std::string_view checkpoint,
                                             Resolution resolution = {});
  std::optional<SessionLease> find(const Principal& principal, std::string_view id) const;
  /// False if there was none.
  bool erase(const Principal& principal, std::string_view id);
  /// At most `count` of the principal's in the order of their ids, the first one after `after`.
  /// Looking renews nothing.
  std::vector<std::shared_ptr<const Session>> page(const Principal& principal,
                                                   std::string_view after, std::size_t count) const;
  std::size_t size() const;

  /// Drops the sessions that had no call for the idle timeout; returns their number.
  std::size_t expire();
  /// The time at which the session expires without further calls.
  std::chrono::system_clock::time_point expire_time(const Session& session) const;

  std::uint32_t max_sessions() const { return max_sessions_; }
  std::chrono::milliseconds idle_timeout() const { return idle_timeout_; }

 private:
  const std::uint32_t max_sessions_;
  const std::chrono::milliseconds idle_timeout_;
  const std::shared_ptr<const Clock> clock_;
  mutable std::shared_mutex mutex_;
  const std::shared_ptr<const CheckpointKeys> keys_;
  std::map<SessionKey, std::shared_ptr<Session>, SessionKeyLess> sessions_;
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
