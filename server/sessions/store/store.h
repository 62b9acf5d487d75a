#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/scheduling/principal.h"
#include "server/sessions/identity.h"
#include "server/sessions/store/store_file.h"

namespace stiefel::server {

/// A session as a row: its resolved scene, and how that was resolved from what its creator gave.
struct StoredSession {
  Principal principal;
  std::string id;
  std::int64_t create_time;  ///< nanoseconds since 1970
  std::string numerics_id;   ///< of the server that wrote the row
  std::uint64_t identity;    ///< hash of the resolved scene
  std::string scene;         ///< as bytes, opaque to the store
  std::string filled_in, cleared;
  std::optional<ChosenMethod> choice;
};

/// A state from which its session can start again.
struct StoredCheckpoint {
  Principal principal;
  std::string id;
  std::string numerics_id;
  std::uint64_t identity;
  std::int64_t step;
  std::string state;  ///< float64, little-endian
};

/// A deleted session, which must not be created again before `until`.
struct DeletedName {
  Principal principal;
  std::string id;
  std::int64_t until;  ///< nanoseconds since 1970
};

/// Keeps sessions, at most one checkpoint of each, and deleted names in an SQLite file, as bytes:
/// it knows neither scenes nor messages. Changes are on disk when `transact` returns. Failures
/// throw StoreError; on a full disk a change that does not fit throws `full`. For one thread at a
/// time.
class Store {
 public:
  /// Throws std::runtime_error (store_file.h).
  explicit Store(const StoreOptions& options);

  using Patience = std::chrono::milliseconds;
  /// The longest time that a transaction waits for the locks of other programs.
  static constexpr Patience patience = std::chrono::seconds(5);

  /// Runs `changes` and commits all of them, or none if it throws. Throws StoreError `unavailable`
  /// if the file was removed, replaced or has a second name (FileWatch), because such changes
  /// would be lost.
  void transact(const std::function<void()>& changes, Patience wait = patience);
  /// Returns why every transaction would be refused.
  std::optional<std::string> fault() const { return file_.watch.fault(); }

  /// Replaces the row of the session's principal and id, and removes its checkpoint.
  void put(const StoredSession& session);
  /// Erases a session and its checkpoint, if there is one.
  void erase(const Principal& principal, std::string_view id);
  void put(const StoredCheckpoint& checkpoint);
  void put(const DeletedName& deleted_name);

  /// Returns the deleted names with `until` > now, the next to end first.
  std::vector<DeletedName> deleted_names(std::int64_t now);
  /// Removes the deleted names whose time is over and, of those beyond `most_deleted_names`, the
  /// oldest of the principals that have most.
  void trim_deleted_names(std::int64_t now);
  /// Whether more than a quarter of `most_deleted_names` were put since the last trim.
  bool deleted_names_pile_up() const { return since_trim_ > most_deleted_names / 4; }
  static constexpr std::int64_t most_deleted_names = std::int64_t{1} << 18;
  /// Removes the checkpoints with another numerics id and those without a session; returns their
  /// number.
  std::int64_t drop_checkpoints_except(std::string_view numerics_id);
  /// Moves the log's pages into the file as far as that can grow, so that the log begins anew.
  void empty_log() noexcept;

  /// A session's row, with its checkpoint if there is a valid one.
  struct Row {
    StoredSession session;
    std::optional<StoredCheckpoint> checkpoint;
  };
  /// Reads all sessions one by one. Must be destroyed before the next change.
  class Reader {
   public:
    explicit Reader(Store& store);
    /// Returns the next row; nothing after the last one. Throws StoreError `damaged` for a row that
    /// does not match its digest.
    std::optional<Row> next();

   private:
    Statement select_;
  };

 private:
  void check_names() const {
    if (const auto wrong = fault()) throw StoreError(WriteFault::Kind::unavailable, *wrong);
  }

  std::int64_t since_trim_ = 0;  // deleted names put since the last trim
  StoreFile file_;
  Statement put_session_, erase_session_, put_checkpoint_, erase_checkpoint_, put_deleted_name_;
};

}  // namespace stiefel::server
