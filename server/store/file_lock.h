#pragma once

#include <string>

namespace stiefel::server {

/// Locks a file for this process with flock(2). The kernel releases the lock when the process ends,
/// in whatever way. Creates the file if there is none, and leaves it.
class FileLock {
 public:
  /// Throws std::runtime_error with the reason; "in use by process 123" if another process holds
  /// it.
  explicit FileLock(const std::string& file);
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;

 private:
  int descriptor_;
};

}  // namespace stiefel::server
