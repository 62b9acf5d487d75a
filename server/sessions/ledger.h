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
    unavailable,  ///< the disk did not take it now: an I/O error, a lock, a read-only file system
    damaged,      ///< the file is no sound store
    out_of_memory
  };
  Kind kind;
  std::string what;
};

/// The outcome of a change that is being written: none as long as it is pending. Thread-safe.
class Receipt {
 public:
  /// Gets no fault when the change is on disk.
  using Done = std::function<void(const std::optional<WriteFault>&)>;

  /// Calls `done` once: now if the outcome is known, else on the thread that settles it.
  void then(Done done);
  /// Once. Functions that throw must not be waiting.
  void settle(std::optional<WriteFault> fault) noexcept;

 private:
  std::mutex mutex_;
  bool settled_ = false;
  std::optional<WriteFault> fault_;  // constant once settled
  std::vector<Done> waiting_;
};

/// Where a registry's changes are written, in the order of the calls. `put`, `erase` and `bury` are
/// called under the registry's lock: they note the change and return, and do not wait for a disk.
class Ledger {
 public:
  using Time = std::chrono::system_clock::time_point;

  virtual ~Ledger() = default;

  /// A new session. If it cannot be written, the ledger drops it from the registry before it
  /// settles the receipt.
  virtual std::shared_ptr<Receipt> put(std::shared_ptr<Session> session) = 0;
  /// A session has expired.
  virtual std::shared_ptr<Receipt> erase(const Principal& principal, std::string id) = 0;
  /// A session was deleted, and no handle creates it again before `until`; also called for an id
  /// that the registry does not know, whose row may be there because an earlier deletion failed.
  virtual std::shared_ptr<Receipt> bury(const Principal& principal, std::string id, Time until) = 0;
  /// A session has a new cached state, which may be written some time later, or never.
  virtual void cached(std::weak_ptr<Session> session) noexcept = 0;
};

}  // namespace stiefel::server
