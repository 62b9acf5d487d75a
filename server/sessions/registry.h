#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "server/scheduling/memory_budget.h"
#include "server/scheduling/principal.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/pending_write.h"
#include "server/sessions/server_session.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {

using Clock = std::function<std::chrono::steady_clock::time_point()>;

/// A session of a registry: its name, whose it is, since when, and whether it is in use.
/// Thread-safe.
class RegisteredSession : public Session, public std::enable_shared_from_this<RegisteredSession> {
 public:
  using Time = std::chrono::system_clock::time_point;

  /// As Session. `clock` measures the idle time.
  RegisteredSession(Principal owner, std::string id, Scene scene, std::optional<Choice> choice,
                    std::shared_ptr<const Clock> clock, MemoryBudget& memory,
                    Time create_time = Time::clock::now());

  const Principal& owner() const { return owner_; }
  const std::string& id() const { return id_; }
  /// Set where the method was chosen for a tolerance.
  const std::optional<Choice>& choice() const { return choice_; }
  Time create_time() const { return create_time_; }
  /// Keeps the session's slot in its owner's quota until the session is destroyed. Call it once.
  void hold_slot(std::shared_ptr<void> slot) { slot_ = std::move(slot); }

  std::chrono::steady_clock::duration idle_time() const {
    if (in_use()) return {};
    return (*clock_)().time_since_epoch() - std::chrono::steady_clock::duration(last_use_.load());
  }
  bool in_use() const { return uses_.load() > 0; }
  /// Returns a reference, as a call holds it.
  std::shared_ptr<RegisteredSession> use();
  /// Whether the session is deleted or expired: running calls go on, new ones do not find it.
  bool closed() const { return closed_.load(std::memory_order_relaxed); }

 private:
  friend class Registry;
  void touch() { last_use_ = (*clock_)().time_since_epoch().count(); }

  const Principal owner_;
  const std::string id_;
  const std::optional<Choice> choice_;
  const std::shared_ptr<const Clock> clock_;
  const Time create_time_;
  std::shared_ptr<void> slot_;
  PendingWrite pending_write_;  // guarded by the registry's lock
  std::atomic<std::chrono::steady_clock::rep> last_use_ = 0;
  std::atomic<int> uses_ = 0;
  std::atomic<bool> closed_ = false;
};

/// A reference to a session in use: the session does not expire while there is one, and its idle
/// time starts again afterwards.
using SessionRef = std::shared_ptr<RegisteredSession>;

/// The names of deleted sessions, each for a lifetime, so that no client that still uses a name
/// creates its session again. Drops the oldest when there are too many. Not thread-safe.
class Tombstones {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::size_t max_count = std::size_t{1} << 16;

  explicit Tombstones(std::chrono::milliseconds lifetime) : lifetime_(lifetime) {}

  /// Reserves the bytes of a tombstone, giving up caches; returns no reservation if they do not
  /// fit.
  static MemoryLease reserve(std::string_view name, MemoryBudget& memory);

  /// Records that the session `name` is deleted now; restarts the lifetime of a name that is there.
  /// If `memory` reserves nothing, the new tombstone takes the place of the oldest.
  void put(std::string name, Time now,
           MemoryLease memory = MemoryLease(MemoryBudget::unlimited(), 0));
  /// Whether the session `name` was deleted less than a lifetime ago.
  bool contains(std::string_view name, Time now) const {
    const auto found = by_name_.find(name);
    return found != by_name_.end() && now - found->second->deleted < lifetime_;
  }
  /// Drops those that are older than the lifetime.
  void expire(Time now);
  std::size_t size() const { return order_.size(); }

 private:
  struct Tombstone {
    std::string name;
    Time deleted;
    MemoryLease memory;
  };
  void drop(std::list<Tombstone>::iterator tombstone);

  const std::chrono::milliseconds lifetime_;
  std::list<Tombstone> order_;  // the oldest first
  std::unordered_map<std::string_view, std::list<Tombstone>::iterator> by_name_;
};

/// The sessions by their principals and ids. Thread-safe.
class Registry {
 public:
  using Time = RegisteredSession::Time;

  /// The sessions give up their caches when `memory` runs out of bytes.
  Registry(std::uint32_t max_sessions, std::chrono::milliseconds idle_timeout, Clock clock,
           MemoryBudget& memory = MemoryBudget::unlimited());
  ~Registry();

  struct Created {
    SessionRef session;
    bool created;
    PendingWrite pending_write = {};
  };
  enum class Conflict { other_scene, too_many, deleted };
  using CreateError = std::variant<Conflict, CheckpointRefusal, Overflow>;

  /// Returns a new session, or the principal's session with this id if its scene is the same.
  /// Adds the state of `checkpoint`, unless that is empty, to the session's cache. Always checks
  /// the checkpoint, and that the fields at step 0 are finite, since no others may be sent. With
  /// `recreate`, refuses an id that was deleted within the idle timeout. A new session takes its
  /// bytes from `memory`, a part of the registry's budget; null means that budget itself. Throws
  /// MemoryExhausted.
  std::expected<Created, CreateError> create(const Principal& principal, const std::string& id,
                                             Scene scene, std::string_view checkpoint,
                                             std::optional<Choice> choice = {},
                                             bool recreate = false, MemoryBudget* memory = nullptr);
  /// Returns null if there is no such session.
  SessionRef find(const Principal& principal, std::string_view id) const;
  /// Deletes the session, and keeps its id as deleted even if there is no such session: it may be
  /// on its way here from another server. The id takes its bytes from `memory`, if they fit.
  PendingWrite erase(const Principal& principal, std::string_view id,
                     MemoryBudget* memory = nullptr);
  /// Whether the session was deleted within the idle timeout and not created again.
  bool deleted(const Principal& principal, std::string_view id) const;
  /// Returns at most `count` of the principal's sessions in the order of their ids, starting after
  /// the id `after`. Does not renew them.
  std::vector<std::shared_ptr<const RegisteredSession>> page(const Principal& principal,
                                                             std::string_view after,
                                                             std::size_t count) const;
  std::size_t size() const;

  /// Drops the sessions that had no call for the idle timeout and returns their number.
  std::size_t expire();
  /// The time after which to call `expire` again: a few times in every idle timeout.
  std::chrono::milliseconds sweep_interval() const {
    return std::clamp<std::chrono::milliseconds>(idle_timeout_ / 4, std::chrono::milliseconds(10),
                                                 std::chrono::seconds(5));
  }
  /// Returns the time at which the session expires if no further call uses it.
  Time expire_time(const RegisteredSession& session) const {
    return Time::clock::now() +
           std::chrono::duration_cast<Time::duration>(idle_timeout_ - session.idle_time());
  }

  /// A change of the sessions: a new session or, where `session` is null, the end of one.
  struct Change {
    std::shared_ptr<RegisteredSession> session;
    Principal principal = {};
    std::string id = {};
    std::optional<Time> until = {};  ///< of its tombstone; none for a session that expired
  };
  /// Queues a change for the disk and returns at once. It is called in the order of the changes,
  /// under the registry's lock, and must take out a session that it cannot write (`drop`). A
  /// deletion may be of an id that the registry does not know: the write of an earlier deletion may
  /// have failed.
  using Record = std::function<PendingWrite(Change)>;
  /// Records every change from now on.
  void record_with(Record record) {
    const std::lock_guard lock(mutex_);
    record_ = std::move(record);
  }
  /// Whether changes are recorded.
  bool durable() const { return record_ != nullptr; }
  /// Adds a stored session, even beyond `max_sessions`. Call it before `record_with`.
  void restore(std::shared_ptr<RegisteredSession> session);
  /// Adds a stored deletion, which lasts until `until`, but at most the idle timeout from now. Call
  /// it before `record_with`, in the order of the deletions.
  void restore_deletion(const Principal& principal, std::string id, Time until,
                        MemoryBudget* memory = nullptr);
  /// Takes out `session`, unless another one has taken its name. Does not record it.
  void drop(const RegisteredSession& session);
  /// Returns the sessions with a state that `take_new_state` has not returned.
  std::vector<std::shared_ptr<RegisteredSession>> with_new_states() const;
  const std::shared_ptr<const Clock>& clock() const { return clock_; }
  /// Gives up about `bytes` bytes of caches, first of the sessions that were unused for longest;
  /// only of the principal `of` unless that is null.
  void evict(std::uint64_t bytes, const Principal* of = nullptr) const;

  std::uint32_t max_sessions() const { return max_sessions_; }
  std::chrono::milliseconds idle_timeout() const { return idle_timeout_; }

 private:
  /// By principal and id: two principals may use one id, each for its own session.
  using Key = std::tuple<std::string, std::string>;
  using Sessions = std::map<Key, std::shared_ptr<RegisteredSession>, std::less<>>;

  // All of these require the lock.
  bool has_tombstone(const Principal& principal, std::string_view id) const;
  Tombstones& tombstones_of(const Principal& principal) {
    return tombstones_.try_emplace(principal.name, idle_timeout_).first->second;
  }
  PendingWrite record(Change change) {
    return record_ ? record_(std::move(change)) : PendingWrite();
  }
  /// Closes a session and takes it out; it is destroyed with what is returned, after the lock.
  std::shared_ptr<RegisteredSession> take_out(Sessions::iterator place);

  const std::uint32_t max_sessions_;
  const std::chrono::milliseconds idle_timeout_;
  const std::shared_ptr<const Clock> clock_;
  MemoryBudget& memory_;
  mutable std::shared_mutex mutex_;
  Record record_;  // guarded by mutex_, as what follows
  Sessions sessions_;
  /// By principal, so that the deletions of one do not push out the tombstones of another.
  std::map<std::string, Tombstones, std::less<>> tombstones_;
};

}  // namespace stiefel::server
