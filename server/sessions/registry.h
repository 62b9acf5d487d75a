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

#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/ledger.h"
#include "server/sessions/principal.h"
#include "server/sessions/session.h"
#include "server/sessions/tombstones.h"

namespace stiefel::server {

/// The key of a session in the registry: two principals may use one id, each for its own session.
struct SessionKey {
  std::string principal, id;
};

/// Orders by principal, then by id.
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
  /// `keys` sign and verify the checkpoints; null means the keys of the process. The sessions give
  /// up their caches when `memory` runs out of bytes.
  Registry(std::uint32_t max_sessions, std::chrono::milliseconds idle_timeout, Clock clock,
           std::shared_ptr<const CheckpointKeys> keys = nullptr,
           MemoryBudget& memory = MemoryBudget::unlimited());
  ~Registry();

  struct Created {
    SessionLease session;
    bool created;
    bool checkpoint_ignored = false;  ///< another server's key signed it: CheckpointFault::foreign
    std::shared_ptr<Receipt> receipt = {};  ///< null without a ledger: nothing to wait for
  };
  enum class Conflict { other_scene, too_many, deleted };
  using CreateError = std::variant<Conflict, CheckpointRefusal, Overflow>;

  /// Returns a new session, or the principal's session with this id if its scene is the same.
  /// Adopts the state of `checkpoint`, unless that is empty, into the session's cache; ignores a
  /// checkpoint signed with another server's key. Always checks the checkpoint, and that the fields
  /// at step 0 are finite, since no others may be sent. With `recreate`, refuses an id that was
  /// deleted within the idle timeout. A new session takes its bytes from `memory`, a part of the
  /// registry's budget; null means that budget itself. Throws MemoryExhausted.
  std::expected<Created, CreateError> create(const Principal& principal, const std::string& id,
                                             Scene scene, std::string_view checkpoint,
                                             Resolution resolution = {}, bool recreate = false,
                                             MemoryBudget* memory = nullptr);
  std::optional<SessionLease> find(const Principal& principal, std::string_view id) const;
  struct Erased {
    bool found;
    std::shared_ptr<Receipt> receipt = {};  ///< null without a ledger
    explicit operator bool() const { return found; }
  };
  /// Deletes the session. Marks the id as deleted even if there is no such session: it may be on
  /// its way here from another server. The mark takes its bytes from `memory`, as in `create`,
  /// if they fit.
  Erased erase(const Principal& principal, std::string_view id, MemoryBudget* memory = nullptr);
  /// Whether the session was deleted within the idle timeout and not created again.
  bool deleted(const Principal& principal, std::string_view id) const;
  /// Returns at most `count` of the principal's sessions in the order of their ids, starting after
  /// the id `after`. Does not renew them.
  std::vector<std::shared_ptr<const Session>> page(const Principal& principal,
                                                   std::string_view after, std::size_t count) const;
  std::size_t size() const;

  /// Drops the sessions that had no call for the idle timeout and returns their number.
  std::size_t expire();
  /// Returns the time at which the session expires if no further call uses it.
  std::chrono::system_clock::time_point expire_time(const Session& session) const;

  /// Writes every change from now on to `ledger`, in order. The ledger must outlive the calls.
  void write_to(Ledger& ledger);
  /// Whether there is a ledger.
  bool durable() const { return ledger_ != nullptr; }
  /// Adds a session that the ledger has already, even beyond `max_sessions`. Call it before
  /// `write_to`.
  void restore(std::shared_ptr<Session> session);
  /// Adds a deletion that the ledger has already; it lasts until `until`, but at most the idle
  /// timeout from now. Call it before `write_to`, for each principal in the order of `until`.
  void bury(const Principal& principal, std::string id, Ledger::Time until,
            MemoryBudget* memory = nullptr);
  /// Removes `session`, unless another one has taken its name. Does not tell the ledger.
  void drop(const Session& session);
  const std::shared_ptr<const Clock>& clock() const { return clock_; }
  const std::shared_ptr<const CheckpointKeys>& keys() const { return keys_; }
  /// Gives up about `bytes` bytes of caches, first of the sessions that were unused for longest;
  /// only of the principal `of` unless that is null.
  void shed(std::uint64_t bytes, const Principal* of = nullptr) const;

  std::uint32_t max_sessions() const { return max_sessions_; }
  std::chrono::milliseconds idle_timeout() const { return idle_timeout_; }

 private:
  /// Requires the lock, as does `tombstones_of`.
  bool has_tombstone(const Principal& principal, std::string_view id) const;
  Tombstones& tombstones_of(const Principal& principal);

  const std::uint32_t max_sessions_;
  const std::chrono::milliseconds idle_timeout_;
  const std::shared_ptr<const Clock> clock_;
  Ledger* ledger_ = nullptr;
  MemoryBudget& memory_;
  mutable std::shared_mutex mutex_;
  const std::shared_ptr<const CheckpointKeys> keys_;
  std::map<SessionKey, std::shared_ptr<Session>, SessionKeyLess> sessions_;
  /// By principal, so that the deletions of one do not push out the tombstones of another.
  std::map<std::string, Tombstones, std::less<>> tombstones_;  // guarded by mutex_
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
