#pragma once

#include <future>
#include <optional>
#include <string>

namespace stiefel::server {

/// Why a change is not on disk.
struct WriteFault {
  enum class Kind {
    full,         ///< no space on the disk
    unavailable,  ///< the file could not be written: an I/O error, a read-only file system, a file
                  ///< that was removed
    locked,       ///< another program holds the file's lock
    damaged,      ///< the file is not a valid store
    out_of_memory
  };
  Kind kind;
  std::string what;
};

/// A change that is being written: has no fault when the change is on disk. Not `valid` without a
/// store, when there is nothing to wait for.
using PendingWrite = std::shared_future<std::optional<WriteFault>>;

}  // namespace stiefel::server
