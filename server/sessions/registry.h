#pragma once

#include <algorithm>
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
#include <variant>
#include <vector>

#include "server/scheduling/memory_budget.h"
#include "server/scheduling/principal.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/server_session.h"
#include "server/sessions/write_ahead_log.h"

namespace stiefel::server {

/// Keeps the names of deleted sessions, each for a lifetime, so that no client that still uses a
/// name creates its session again. Drops the oldest names when there are too many. Not thread-safe.
class DeletedNames {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::size_t max_count = std::size_t{1} << 16;
  /// The most bytes of all entries; an entry counts its name and `entry_bytes`.
  static constexpr std::size_t max_bytes = std::size_t{16} << 20;
  static constexpr std::size_t entry_bytes = 160;

  explicit DeletedNames(std::chrono::milliseconds lifetime) : lifetime_(lifetime) {}

  /// Returns the bytes of an entry.
  static std::size_t bytes(std::string_view name) { return name.size() + entry_bytes; }
  /// Returns a lease of these bytes, without a budget if they do not fit. Gives up caches.
  static MemoryLease lease(std::string_view name, MemoryBudget& memory);

  /// Records that the session `name` is deleted now; restarts the lifetime of a name that is there.
  /// `memory` is the lease of the entry. If that has no budget, drops as many bytes of the oldest
  /// entries as the new one takes.
  void put(std::string name, Time now,
           MemoryLease memory = MemoryLease(MemoryBudget::unlimited(), 0));
  /// Whether the session `name` was deleted less than a lifetime ago.
  bool contains(std::string_view name, Time now) const {
    const auto found = by_name_.find(name);
    return found != by_name_.end() && now - found->second->deleted < lifetime_;
  }
  void remove(std::string_view name) {
    if (const auto found = by_name_.find(name); found != by_name_.end()) drop(found->second);
  }
  /// Drops the names that are older than the lifetime.
  void expire(Time now);
  std::size_t size() const { return order_.size(); }

 private:
  struct Entry {
    std::string name;
    Time deleted;
    MemoryLease memory;
  };
  void drop(std::list<Entry>::iterator entry);

  const std::chrono::milliseconds lifetime_;
  std::list<Entry> order_;  // the oldest first
  std::unordered_map<std::string_view, std::list<Entry>::iterator> by_name_;
  std::size_t bytes_ = 0;
};

/// The sessions by their principals and ids. Thread-safe.
class Registry {
 public:
  /// The sessions give up their caches when `memory` runs out of bytes.
  Registry(std::uint32_t max_sessions, std::chrono::milliseconds idle_timeout, Clock clock,
           MemoryBudget& memory = MemoryBudget::unlimited());
  ~Registry();

  struct Created {
    SessionLease session;
    bool created;
    std::shared_ptr<PendingWrite> pending_write = {};  ///< null without a log: nothing to wait for
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
    std::shared_ptr<PendingWrite> pending_write = {};  ///< null without a log
    explicit operator bool() const { return found; }
  };
  /// Deletes the session, and keeps its id as deleted even if there is no such session: it may be
  /// on its way here from another server. The id takes its bytes from `memory`, if they fit.
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
  /// The time after which to call `expire` again: a few times in every idle timeout.
  std::chrono::milliseconds sweep_interval() const {
    return std::clamp<std::chrono::milliseconds>(idle_timeout_ / 4, std::chrono::milliseconds(10),
                                                 std::chrono::minutes(1));
  }
  /// Returns the time at which the session expires if no further call uses it.
  std::chrono::system_clock::time_point expire_time(const Session& session) const {
    return std::chrono::system_clock::now() +
           std::chrono::duration_cast<std::chrono::system_clock::duration>(idle_timeout_ -
                                                                           session.idle_time());
  }

  /// Writes every change from now on to `log`, in order. The write-ahead log must outlive the
  /// calls.
  void write_to(WriteAheadLog& log) {
    const std::lock_guard lock(mutex_);
    log_ = &log;
    for (const auto& [key, session] : sessions_) session->write_to(log);
  }
  /// Whether there is a write-ahead log.
  bool durable() const { return log_ != nullptr; }
  /// Adds a stored session, even beyond `max_sessions`. Call it before `write_to`.
  void restore(std::shared_ptr<Session> session) {
    const std::lock_guard lock(mutex_);
    Key key{session->owner().name, session->id()};
    sessions_.emplace(std::move(key), std::move(session));
  }
  /// Adds a stored deletion, which lasts until `until`, but at most the idle timeout from now. Call
  /// it before `write_to`, for each principal in the order of `until`.
  void mark_deleted(const Principal& principal, std::string id, WriteAheadLog::Time until,
                    MemoryBudget* memory = nullptr);
  /// Removes `session`, unless another one has taken its name. Does not tell the write-ahead log.
  void drop(const Session& session);
  const std::shared_ptr<const Clock>& clock() const { return clock_; }
  /// Gives up about `bytes` bytes of caches, first of the sessions that were unused for longest;
  /// only of the principal `of` unless that is null.
  void evict(std::uint64_t bytes, const Principal* of = nullptr) const;

  std::uint32_t max_sessions() const { return max_sessions_; }
  std::chrono::milliseconds idle_timeout() const { return idle_timeout_; }

 private:
  /// Requires the lock, as does `deleted_names_of`.
  bool has_deleted_name(const Principal& principal, std::string_view id) const {
    const auto deleted_names = deleted_names_.find(principal.name);
    return deleted_names != deleted_names_.end() && deleted_names->second.contains(id, (*clock_)());
  }
  DeletedNames& deleted_names_of(const Principal& principal) {
    return deleted_names_.try_emplace(principal.name, idle_timeout_).first->second;
  }

  const std::uint32_t max_sessions_;
  const std::chrono::milliseconds idle_timeout_;
  const std::shared_ptr<const Clock> clock_;
  WriteAheadLog* log_ = nullptr;
  MemoryBudget& memory_;
  mutable std::shared_mutex mutex_;
  /// By principal and id: two principals may use one id, each for its own session.
  using Key = std::tuple<std::string, std::string>;
  using Sessions = std::map<Key, std::shared_ptr<Session>, std::less<>>;
  /// Closes a session and takes it out; it is destroyed with what is returned, after the lock.
  std::shared_ptr<Session> take_out(Sessions::iterator place);

  Sessions sessions_;
  /// By principal, so that the deletions of one do not push out the deleted names of another.
  std::map<std::string, DeletedNames, std::less<>> deleted_names_;  // guarded by mutex_
};

}  // namespace stiefel::server
