#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/sessions/principal.h"
#include "server/store/store_file.h"

namespace stiefel::server {

/// What a method was chosen for, and why this one.
struct StoredChoice {
  double tolerance, horizon;
  std::string reason;
};

/// A session as a row: its resolved scene, and how that came from what its creator gave.
struct StoredSession {
  Principal principal;
  std::string id;
  std::int64_t create_time;  ///< nanoseconds since 1970
  std::string numerics_id;   ///< of the server that made it
  std::uint64_t identity;    ///< hash of the resolved scene
  std::string scene;         ///< as bytes, opaque here
  std::string filled_in, cleared;
  std::optional<StoredChoice> choice;
};

/// A state that its session can start again from.
struct StoredCheckpoint {
  Principal principal;
  std::string id;
  std::string numerics_id;
  std::uint64_t identity;
  std::int64_t step;
  std::string state;  ///< float64, little-endian
};

/// A session that was deleted: nobody creates it again before `until`.
struct Tombstone {
  Principal principal;
  std::string id;
  std::int64_t until;  ///< nanoseconds since 1970
};

/// Sessions, at most one checkpoint of each, and tombstones in an SQLite file. Bytes in, bytes out:
/// it knows neither scenes nor messages. Changes are on disk when `transact` returns. What fails
/// throws StoreError. For one thread at a time.
class Store {
 public:
  /// Throws std::runtime_error (store_file.h).
  explicit Store(const StoreOptions& options);

  /// Runs `changes` and commits: all of them, or none if it throws.
  void transact(const std::function<void()>& changes);

  /// Replaces the row of that principal and id, and removes its checkpoint.
  void put(const StoredSession& session);
  /// With its checkpoint; nothing if there is none.
  void erase(const Principal& principal, std::string_view id);
  void put(const StoredCheckpoint& checkpoint);
  void put(const Tombstone& tombstone);

  /// Those with `until` > now, the next to end first.
  std::vector<Tombstone> tombstones(std::int64_t now);
  /// Removes the tombstones whose time is over, and the oldest ones beyond `most_tombstones`: of
  /// the principals that have most.
  void trim_tombstones(std::int64_t now);
  /// Whether so many were put since the last time that it is worth while.
  bool tombstones_pile_up() const { return since_trim_ > most_tombstones_ / 4; }
  /// An eighth of the store's limit, and 2^18 at most.
  std::int64_t most_tombstones() const { return most_tombstones_; }
  /// Removes the older half of them, of the principals that have most; false if there were none.
  bool halve_tombstones();
  /// Removes the checkpoints that another numerics id wrote, and those without a session; returns
  /// their number.
  std::int64_t drop_checkpoints_except(std::string_view numerics_id);
  /// On a full disk: removes every checkpoint, trims the tombstones and empties the log.
  void make_room(std::int64_t now) noexcept;
  /// `transact` with what is held back for deletions.
  void transact_with_reserve(const std::function<void()>& changes);

  /// A row with its checkpoint, if that is sound.
  struct Row {
    StoredSession session;
    std::optional<StoredCheckpoint> checkpoint;
  };
  /// All sessions, one after another. It must be gone before a change.
  class Reader {
   public:
    explicit Reader(Store& store);
    /// Nothing after the last one. A row that does not have its digest is a StoreError, damaged.
    std::optional<Row> next();

   private:
    Statement select_;
  };

 private:
  void empty_log() noexcept;
  void keep_newest_tombstones(std::int64_t count);

  const std::int64_t most_tombstones_;
  std::int64_t since_trim_ = 0;  // tombstones
  StoreFile file_;
  Statement put_session_, erase_session_, put_checkpoint_, erase_checkpoint_, put_tombstone_;
};

}  // namespace stiefel::server
