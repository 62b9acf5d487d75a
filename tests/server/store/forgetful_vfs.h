#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <vector>

namespace stiefel::test {

/// A file system of SQLite that keeps what is written in memory until it is synchronized, as an
/// operating system does, and at a crash drops what was not; or, as a disk does that had begun with
/// it, keeps some of its sectors. Locks and shared memory are those of the real file system.
/// Thread-safe. One at a time.
class ForgetfulVfs {
 public:
  static constexpr const char* name = "forgetful";

  ForgetfulVfs();
  ~ForgetfulVfs();
  ForgetfulVfs(const ForgetfulVfs&) = delete;
  ForgetfulVfs& operator=(const ForgetfulVfs&) = delete;

  /// Fails the n-th call from now that changes a file or synchronizes one (n = 0: the next one),
  /// and every call after it, as if the machine had stopped there. n < 0: none.
  void crash_at(std::int64_t n);
  /// The calls of that kind so far.
  std::int64_t calls() const;
  bool crashed() const;
  /// What the disk holds after the crash: of the writes that were not synchronized each sector with
  /// the probability `kept`. All files must be closed; the VFS is as new afterwards.
  void restart(double kept, std::mt19937_64& random);

  /// Used by the callbacks of SQLite.
  struct Write {
    std::int64_t offset;
    std::string bytes;
    bool truncate;  ///< to `offset`
  };
  struct Content {
    std::string bytes;           ///< what a reader sees
    std::vector<Write> pending;  ///< since the last synchronization
  };
  /// False when the machine has stopped.
  bool change(const std::string& path, const std::function<bool(Content&)>& use);
  bool read(const std::string& path, const std::function<void(const Content&)>& use);
  bool load(const std::string& path);
  bool synchronize(const std::string& path);

 private:
  bool alive();

  mutable std::mutex mutex_;
  std::map<std::string, Content> files_;
  std::int64_t calls_ = 0, crash_at_ = -1;
  bool crashed_ = false;
};

}  // namespace stiefel::test
