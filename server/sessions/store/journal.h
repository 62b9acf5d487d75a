#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "server/sessions/store/store.h"
#include "server/sessions/write_ahead_log.h"

namespace stiefel::server {

/// Writes a registry's changes to a store, on a thread of its own. The changes that arrive during
/// one transaction form the next, so that many calls share one wait for the disk. A transaction
/// that fails is repeated change by change, so that only what does not fit fails. A change waits
/// for the lock of another program for `Store::patience` from its arrival, whatever waits before
/// it.
///
/// Writes checkpoints when no change waits, at the latest 5 s after a pass is due: the last state
/// of each session, a few seconds after it was cached. Drops those beyond `max_checkpoint_bytes`,
/// and those whose writing fails.
class Journal final : public WriteAheadLog {
 public:
  struct Hooks {
    /// Converts a session to a row.
    std::function<StoredSession(const Session&)> to_row;
    /// Drops a session that could not be written from the registry.
    std::function<void(const Session&)> drop;
    /// Reports a change or a checkpoint that could not be written.
    std::function<void(const WriteFault&)> report;
    /// Is called when `Store::fault` changes, which the journal reads with each pass.
    std::function<void(const std::optional<std::string>&)> watched = {};
  };
  /// The time between two passes, which write checkpoints and look at the names of the files.
  static constexpr auto checkpoint_interval = std::chrono::milliseconds(2000);
  /// The most bytes that a pass writes.
  static constexpr std::size_t max_checkpoint_bytes = std::size_t{16} << 20;
  /// The changes and the bytes at which a transaction is full.
  static constexpr std::size_t max_changes = 1024;
  static constexpr std::size_t max_bytes = std::size_t{32} << 20;

  /// The store and what the hooks use must outlive the journal.
  Journal(Store& store, Hooks hooks,
          std::chrono::milliseconds between_checkpoints = checkpoint_interval);
  /// Writes all waiting changes and checkpoints.
  ~Journal() override;

  std::shared_ptr<PendingWrite> put(std::shared_ptr<Session> session) override {
    return submit({.session = std::move(session), .principal = {}, .id = {}, .until = {}});
  }
  std::shared_ptr<PendingWrite> erase(const Principal& principal, std::string id) override {
    return submit({.session = {}, .principal = principal, .id = std::move(id), .until = {}});
  }
  std::shared_ptr<PendingWrite> mark_deleted(const Principal& principal, std::string id,
                                             Time until) override {
    return submit({.session = {}, .principal = principal, .id = std::move(id), .until = until});
  }
  void cached(std::weak_ptr<Session> session) noexcept override;

  /// The number of transactions that wrote sessions, deletions or deleted names. Thread-safe.
  std::uint64_t transactions() const { return transactions_.load(std::memory_order_relaxed); }

 private:
  /// A session to write, or the name of one to erase, with a deleted name if `until` is set.
  struct Change {
    std::shared_ptr<Session> session;
    Principal principal;
    std::string id;
    std::optional<Time> until;
    std::shared_ptr<PendingWrite> pending_write = std::make_shared<PendingWrite>();
    std::chrono::steady_clock::time_point deadline =
        std::chrono::steady_clock::now() + Store::patience;
  };

  std::shared_ptr<PendingWrite> submit(Change change);
  void work(const std::stop_token& stop);
  void write(std::span<const Change> changes);
  std::size_t write_together(std::span<const Change> changes);
  std::optional<WriteFault> transact(std::span<const Change> changes);
  void apply(const Change& change);
  void settle(const Change& change, const std::optional<WriteFault>& fault);
  void trim_deleted_names() noexcept;
  void watch() noexcept;
  void report(const WriteFault& fault) const noexcept;
  void write_checkpoints(std::vector<std::weak_ptr<Session>> sessions);

  Store& store_;
  const Hooks hooks_;
  const std::chrono::milliseconds between_checkpoints_;
  std::atomic<std::uint64_t> transactions_ = 0;
  std::optional<std::string> watched_;  // what `hooks_.watched` was told last

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::vector<Change> queue_;                        // guarded by mutex_
  std::vector<std::weak_ptr<Session>> with_states_;  // guarded by mutex_
  std::jthread thread_;
};

}  // namespace stiefel::server
