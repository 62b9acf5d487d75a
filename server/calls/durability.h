#pragma once

#include <chrono>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/calls/host.h"
#include "server/scheduling/process.h"
#include "server/sessions/registry.h"
#include "server/sessions/store/store.h"
#include "server/sessions/store/store_writer.h"

namespace stiefel::server {

/// Returns a session as a row, with the resolved scene as a stiefel.v1.Scene, which keeps every
/// bit.
StoredSession to_row(const RegisteredSession& session);

using Restored = std::expected<std::shared_ptr<RegisteredSession>, std::string>;

/// Returns the session of a row, with the state of its checkpoint in its cache if that is of this
/// numerics id and fits into the memory; or why this build cannot restore it. A row with the same
/// numerics id gives the stored scene, bit for bit.
Restored from_row(const Store::Row& row, std::shared_ptr<const Clock> clock,
                  MemoryBudget& memory = MemoryBudget::unlimited());

/// Keeps the sessions of a host in a store: restores those that are there and writes every change
/// from then on. Every two seconds it writes the last new state of each session, at most 16 MiB at
/// a time, and looks whether the store's files are there.
class Durability {
 public:
  /// Returns when every session is in the registry; logs those that this build cannot read and
  /// leaves them in the file. Throws std::runtime_error when the store cannot be used. Must be
  /// destroyed after the calls and before the host. Calls `able` with false when the store's files
  /// are removed or replaced, and with true when that is over.
  Durability(const std::string& file, Host& host, std::function<void(bool)> able);
  /// Writes what waits, and the new states.
  ~Durability() { write_checkpoints(); }

 private:
  void restore();
  void restore_sessions(const std::function<void(const Store::Row&)>& use);
  Restored restored(const Store::Row& row, Account& account) const;
  PendingWrite record(Registry::Change change);
  void write_checkpoints() noexcept;
  void watch();
  void report(const WriteFault& fault);

  const std::string file_;
  Host& host_;
  const std::function<void(bool)> able_;
  std::optional<std::string> watched_;  ///< the fault that `able_` was told last
  std::chrono::steady_clock::time_point next_report_ = {};
  std::int64_t unreported_ = 0;
  Store store_;
  StoreWriter writer_;
  Periodic periodic_;
};

}  // namespace stiefel::server
