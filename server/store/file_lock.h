#pragma once

#include <string>

namespace stiefel::server {

/// Locks a file for this process with flock(2). The kernel releases the lock when the process ends,
/// in whatever way. The file stays.
class FileLock {
 public:
  /// Creates the file if there is none, and writes this process's number into it. Throws
  /// std::runtime_error with the reason; "in use by process 123" if another process holds the lock.
  static FileLock with_number(const std::string& file);
  /// Locks a file of other content. Throws std::runtime_error with the reason; "in use by another
  /// process" if that holds the lock.
  explicit FileLock(const std::string& file);
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;

  /// The open file.
  int descriptor() const { return descriptor_; }

 private:
  FileLock(const std::string& file, int flags, bool numbered);

  int descriptor_;
};

}  // namespace stiefel::server
