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
  /// `keys`: of the checkpoints; those of the process if null. The caches of the sessions are given
  /// up for whoever takes memory of the budget.
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

  /// A new session, or the principal's of that id, if its scene is the same; in its cache is what
  /// `checkpoint` holds unless that is empty. The checkpoint is checked in any case, and that the
  /// fields at step 0 are finite numbers: no other is ever sent. A checkpoint that another server
  /// signed is ignored. With `recreate` no session comes back that was deleted within the idle
  /// timeout. `memory`: what a new session takes its bytes of, the registry's budget or a part of
  /// it; that of the registry if null. Throws MemoryExhausted.
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
  /// The id counts as deleted whether it was there or not: a session of it may be on its way here
  /// from another server.
  Erased erase(const Principal& principal, std::string_view id);
  /// Whether it was erased within the idle timeout, and not created anew.
  bool deleted(const Principal& principal, std::string_view id) const;
  /// At most `count` of the principal's in the order of their ids, the first one after `after`.
  /// Looking renews nothing.
  std::vector<std::shared_ptr<const Session>> page(const Principal& principal,
                                                   std::string_view after, std::size_t count) const;
  std::size_t size() const;

  /// Drops the sessions that had no call for the idle timeout; returns their number.
  std::size_t expire();
  /// The time at which the session expires without further calls.
  std::chrono::system_clock::time_point expire_time(const Session& session) const;

  /// Every change from now on is written to `ledger`, in its order; it must outlive the calls.
  void write_to(Ledger& ledger);
  /// Whether there is a ledger.
  bool durable() const { return ledger_ != nullptr; }
  /// Before there is a ledger: a session that is in it already, however many there are.
  void restore(std::shared_ptr<Session> session);
  /// Before there is a ledger: a deletion that is in it already. Of one principal in the order of
  /// their times; none lasts longer than the idle timeout from now.
  void bury(const Principal& principal, std::string id, Ledger::Time until);
  /// Removes this session, unless another one has its name; the ledger does not learn of it.
  void drop(const Session& session);
  const std::shared_ptr<const Clock>& clock() const { return clock_; }
  const std::shared_ptr<const CheckpointKeys>& keys() const { return keys_; }
  /// Gives up about so many bytes of caches, of the sessions first that were not used for longest;
  /// of that principal's alone unless null.
  void shed(std::uint64_t bytes, const Principal* of = nullptr) const;

  std::uint32_t max_sessions() const { return max_sessions_; }
  std::chrono::milliseconds idle_timeout() const { return idle_timeout_; }

 private:
  /// With the lock held.
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
  /// By principal: the deletions of one do not push out the tombstones of another.
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
