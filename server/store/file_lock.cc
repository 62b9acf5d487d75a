#include "server/store/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace stiefel::server {
namespace {

/// Returns the process id that the holder wrote into the file.
std::string holder_of(int descriptor) {
  std::array<char, 32> text{};
  const ssize_t count = pread(descriptor, text.data(), text.size(), 0);
  if (count <= 0) return "another process";
  return "process " + std::string(text.data(), static_cast<std::size_t>(count));
}

}  // namespace

FileLock::FileLock(const std::string& file, int flags, bool numbered)
    : descriptor_(open(file.c_str(), O_RDWR | O_CLOEXEC | flags, 0600)) {
  if (descriptor_ < 0) throw std::runtime_error(file + ": " + std::strerror(errno));
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    const int error = errno;
    const std::string holder = numbered ? holder_of(descriptor_) : "another process";
    close(descriptor_);
    throw std::runtime_error(error == EWOULDBLOCK ? "in use by " + holder
                                                  : file + ": " + std::strerror(error));
  }
}

FileLock::FileLock(const std::string& file) : FileLock(file, 0, false) {}

FileLock FileLock::with_number(const std::string& file) {
  FileLock lock(file, O_CREAT, true);
  // The number serves the error message only; on a full disk the file stays empty.
  const std::string number = std::to_string(getpid());
  if (ftruncate(lock.descriptor_, 0) == 0)
    static_cast<void>(pwrite(lock.descriptor_, number.data(), number.size(), 0) > 0);
  return lock;
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

}  // namespace stiefel::server
