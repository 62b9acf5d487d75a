#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "server/scheduling/principal.h"
#include "server/sessions/store/store_file.h"

namespace stiefel::server {

/// A session as a row: its resolved scene, and the choice of its method.
struct StoredSession {
  Principal principal;
  std::string id;
  std::int64_t create_time;  ///< nanoseconds since 1970
  std::string numerics_id;   ///< of the server that wrote the row
  std::string identity;      ///< SHA-256 of the resolved scene
  std::string scene;         ///< as bytes, opaque to the store
  std::string choice;        ///< as bytes, opaque to the store

  /// Returns references to all of these, in the order of the table.
  template <class Self>
  static auto columns(Self& row) {
    return std::tie(row.principal.name, row.id, row.create_time, row.numerics_id, row.identity,
                    row.scene, row.choice);
  }
};

/// A deleted session, which must not be created again before `until`.
struct Tombstone {
  Principal principal;
  std::string id;
  std::int64_t until;  ///< nanoseconds since 1970
};

/// Keeps sessions, at most one checkpoint of each, and tombstones in an SQLite file, as bytes: it
/// knows neither scenes nor messages. Changes are on disk when `transact` returns. Failures throw
/// StoreError; on a full disk a change that does not fit throws `full`. For one thread at a time,
/// but `fault`.
class Store {
 public:
  /// Throws std::runtime_error (store_file.h).
  explicit Store(const std::string& file);

  /// Runs `changes` and commits all of them, or none if it throws. Throws StoreError `unavailable`
  /// if the file was removed or replaced (FileWatch), because such changes would be lost.
  void transact(const std::function<void()>& changes);
  /// Returns why every transaction would be refused. Thread-safe.
  std::optional<std::string> fault() const { return file_.watch.fault(); }

  /// Replaces the row of the session's principal and id, and removes its checkpoint.
  void put(const StoredSession& session);
  /// Erases a session and its checkpoint, if there is one.
  void erase(const Principal& principal, const std::string& id);
  /// Replaces the checkpoint of a session (checkpoint_bytes.h).
  void put_checkpoint(const Principal& principal, const std::string& id, const std::string& bytes);
  /// Adds a tombstone; removes all before the last `most_tombstones`.
  void put(const Tombstone& tombstone);
  static constexpr std::int64_t most_tombstones = std::int64_t{1} << 18;

  /// Returns the tombstones with `until` > now, in the order of the deletions.
  std::vector<Tombstone> tombstones(std::int64_t now);

  /// A session's row, with its checkpoint or an empty text.
  struct Row {
    StoredSession session;
    std::string checkpoint;
  };
  /// Reads all sessions one by one. Must be destroyed before the next change.
  class Reader {
   public:
    explicit Reader(Store& store);
    /// Returns the next row; nothing after the last one. Throws StoreError `damaged` for a session
    /// that does not match its digest.
    std::optional<Row> next();

   private:
    Statement select_;
    bool done_ = false;
  };

 private:
  void check_names() const {
    if (const auto wrong = fault()) throw StoreError(WriteFault::Kind::unavailable, *wrong);
  }

  StoreFile file_;
  Statement put_session_, erase_session_, put_checkpoint_, erase_checkpoint_, put_tombstone_,
      trim_tombstones_;
};

}  // namespace stiefel::server
