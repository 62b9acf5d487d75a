#pragma once

#include <string>

namespace stiefel::server {

/// Holds a file for this process alone, through flock(2): the kernel lets go of it when the process
/// ends, however it ends. The file is made if it is not there, and stays.
class FileLock {
 public:
  /// Throws std::runtime_error: what is wrong, "in use by process 123" where another one holds it.
  explicit FileLock(const std::string& file);
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;

 private:
  int descriptor_;
};

}  // namespace stiefel::server
