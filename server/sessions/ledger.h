#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/sessions/principal.h"

namespace stiefel::server {

class Session;

/// Why a change is not on disk.
struct WriteFault {
  enum class Kind {
    full,         ///< no space on the disk, or the store's limit is reached
    unavailable,  ///< the file could not be written: an I/O error, a read-only file system, a file
                  ///< that was removed or has a second name
    locked,       ///< another program holds the file's lock
    damaged,      ///< the file is not a valid store
    out_of_memory
  };
  Kind kind;
  std::string what;
};

/// The outcome of a change that is being written, unknown while the write is pending. Thread-safe.
class Receipt {
 public:
  /// Is called without a fault when the change is on disk.
  using Done = std::function<void(const std::optional<WriteFault>&)>;

  /// Calls `done` once: at once if the outcome is known, else on the thread that settles the
  /// receipt.
  void then(Done done);
  /// Sets the outcome and calls the waiting functions, none of which may throw. Call it once.
  void settle(std::optional<WriteFault> fault) noexcept;

 private:
  std::mutex mutex_;
  bool settled_ = false;
  std::optional<WriteFault> fault_;  // constant once settled
  std::vector<Done> waiting_;
};

/// Records a registry's changes in the order of the calls. `put`, `erase` and `bury` are called
/// under the registry's lock: they queue the change and return without waiting for the disk.
class Ledger {
 public:
  using Time = std::chrono::system_clock::time_point;

  virtual ~Ledger() = default;

  /// Records a new session. If it cannot be written, the ledger drops it from the registry before
  /// it settles the receipt.
  virtual std::shared_ptr<Receipt> put(std::shared_ptr<Session> session) = 0;
  /// Records that a session has expired.
  virtual std::shared_ptr<Receipt> erase(const Principal& principal, std::string id) = 0;
  /// Records that a session was deleted and that no client's handle may create it again before
  /// `until`. Also called for an id that the registry does not know: an earlier deletion may have
  /// failed and left its row.
  virtual std::shared_ptr<Receipt> bury(const Principal& principal, std::string id, Time until) = 0;
  /// Records that a session has a new cached state, which may be written later or never.
  virtual void cached(std::weak_ptr<Session> session) noexcept = 0;
};

}  // namespace stiefel::server
