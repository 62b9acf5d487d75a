#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/scheduling/principal.h"

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

/// A change that is being written. Thread-safe.
class PendingWrite {
 public:
  /// Is called without a fault when the change is on disk.
  using Done = std::function<void(const std::optional<WriteFault>&)>;

  /// Calls `done` once: at once if the write has ended, otherwise on the thread that ends it.
  void then(Done done) {
    {
      const std::lock_guard lock(mutex_);
      if (!settled_) return waiting_.push_back(std::move(done));
    }
    done(fault_);
  }
  /// Waits for the end of the write.
  std::optional<WriteFault> wait() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return settled_; });
    return fault_;
  }
  /// Ends the write and calls the waiting functions, none of which may throw. Call it once.
  void settle(std::optional<WriteFault> fault) noexcept {
    std::vector<Done> waiting;
    {
      const std::lock_guard lock(mutex_);
      fault_ = std::move(fault);
      settled_ = true;
      waiting.swap(waiting_);
      ended_.notify_all();
    }
    for (const Done& done : waiting) done(fault_);
  }

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
  bool settled_ = false;
  std::optional<WriteFault> fault_;  // constant once settled
  std::vector<Done> waiting_;
};

/// Records a registry's changes in the order of the calls. `put`, `erase` and `mark_deleted` are
/// called under the registry's lock: they queue the change and return without waiting for the disk.
class WriteAheadLog {
 public:
  using Time = std::chrono::system_clock::time_point;

  virtual ~WriteAheadLog() = default;

  /// Records a new session. One that cannot be written is dropped from the registry before the
  /// write ends.
  virtual std::shared_ptr<PendingWrite> put(std::shared_ptr<Session> session) = 0;
  /// Records that a session has expired.
  virtual std::shared_ptr<PendingWrite> erase(const Principal& principal, std::string id) = 0;
  /// Records that a session was deleted, so that no client's handle creates it again before
  /// `until`. Also for an id that the registry does not know: the write of an earlier deletion may
  /// have failed.
  virtual std::shared_ptr<PendingWrite> mark_deleted(const Principal& principal, std::string id,
                                                     Time until) = 0;
  /// Records that a session has a new cached state, which may be written later or never.
  virtual void cached(std::weak_ptr<Session> session) noexcept = 0;
};

}  // namespace stiefel::server
