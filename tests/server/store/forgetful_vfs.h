#pragma once

#include <cstdint>
#include <random>

namespace stiefel::test {

/// The default file system of SQLite while this object lives: it keeps what is written in memory
/// until it is synchronized, as an operating system does, and at a crash drops what was not; or, as
/// a disk does that had begun with it, keeps some of its sectors. Locks and shared memory are those
/// of the real file system. Thread-safe. One at a time.
class ForgetfulVfs {
 public:
  ForgetfulVfs();
  ~ForgetfulVfs();
  ForgetfulVfs(const ForgetfulVfs&) = delete;
  ForgetfulVfs& operator=(const ForgetfulVfs&) = delete;

  /// Fails the n-th call from now that changes a file or synchronizes one (n = 0: the next one),
  /// and every call after it, as if the machine had stopped there.
  void crash_at(std::int64_t n);
  bool crashed() const;
  /// What the disk holds after the crash: of the writes that were not synchronized each sector with
  /// the probability `kept`. All files must be closed; the VFS is as new afterwards.
  void restart(double kept, std::mt19937_64& random);
};

}  // namespace stiefel::test
