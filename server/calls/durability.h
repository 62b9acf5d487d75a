#pragma once

#include <chrono>
#include <cstddef>
#include <expected>
#include <functional>
#include <memory>
#include <string>

#include "server/calls/host.h"
#include "server/sessions/server_session.h"
#include "server/sessions/store/journal.h"
#include "server/sessions/store/store.h"

namespace stiefel::server {

/// Returns a session as a row, with the resolved scene as a stiefel.v1.Scene, which keeps every
/// bit.
StoredSession to_row(const Session& session);

using Restored = std::expected<std::shared_ptr<Session>, std::string>;

/// Returns the session of a row, with the state of its checkpoint in its cache; or why this build
/// cannot restore it. A row with the same numerics id gives the stored scene, bit for bit.
Restored from_row(const Store::Row& row, std::shared_ptr<const Clock> clock,
                  MemoryBudget& memory = MemoryBudget::unlimited());

/// Keeps the sessions of a host in a store: restores those that are there and writes every change
/// from then on.
class Durability {
 public:
  /// Returns when every session is in the registry; logs those that this build cannot read and
  /// leaves them in the file. Throws std::runtime_error when the store cannot be used. Must be
  /// destroyed after the calls and before the host. Calls `able` with false when the store's files
  /// are removed, replaced or get a second name, and with true when that is over.
  Durability(const StoreOptions& options, Host& host, std::function<void(bool)> able);

 private:
  void restore();
  void restore_sessions(const std::function<void(const Store::Row&)>& use);
  void restore_deleted_names();
  Restored restored(const Store::Row& row, Account& account) const;
  Journal::Hooks hooks();
  void report(const WriteFault& fault);
  void watched(const std::optional<std::string>& fault) const;

  const std::string file_;
  Host& host_;
  const std::function<void(bool)> able_;
  std::chrono::steady_clock::time_point next_report_ = {};
  std::int64_t unreported_ = 0;
  Store store_;
  Journal journal_;
};

}  // namespace stiefel::server
