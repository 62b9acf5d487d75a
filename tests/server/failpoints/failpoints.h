#pragma once

#include <atomic>
#include <map>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>

#include "server/scheduling/failpoint.h"

namespace stiefel::test {

/// How a failpoint fails.
enum class Failure { no_memory, exception };

/// Failpoints of this process: counts how often each is passed, and fails the one that is armed.
class Failpoints {
 public:
  Failpoints() { server::failpoint_hook = &Failpoints::pass; }
  ~Failpoints() { server::failpoint_hook = nullptr; }
  Failpoints(const Failpoints&) = delete;
  Failpoints& operator=(const Failpoints&) = delete;

  /// From now on the name fails at its `at`-th pass, 1 being the next one.
  void arm(const std::string& name, int at, Failure how) {
    const std::lock_guard lock(mutex_);
    armed_ = name;
    left_ = at;
    how_ = how;
    failed_ = false;
    passes_.clear();
  }
  /// Whether it has failed; fails no more.
  bool disarm() {
    const std::lock_guard lock(mutex_);
    armed_.clear();
    return failed_;
  }
  /// Since the start, or since `arm`.
  static std::map<std::string, int> passes() {
    const std::lock_guard lock(mutex_);
    return passes_;
  }

 private:
  static void pass(const char* name) {
    const std::lock_guard lock(mutex_);
    ++passes_[name];
    if (armed_ != name || --left_ != 0) return;
    failed_ = true;
    if (how_ == Failure::no_memory) throw std::bad_alloc();
    throw std::runtime_error(std::string(name) + " fails");
  }

  inline static std::mutex mutex_;
  inline static std::string armed_;
  inline static int left_ = 0;
  inline static Failure how_ = Failure::no_memory;
  inline static bool failed_ = false;
  inline static std::map<std::string, int> passes_;
};

}  // namespace stiefel::test
