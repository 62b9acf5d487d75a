#pragma once

#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

namespace stiefel::server {

/// An open file descriptor, closed by the destructor; -1 for none.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() { reset(); }

  explicit operator bool() const { return number_ >= 0; }
  int get() const { return number_; }
  /// Returns the number, which the caller must close from now on.
  int release() { return std::exchange(number_, -1); }
  void reset() {
    if (number_ >= 0) close(std::exchange(number_, -1));
  }

 private:
  int number_ = -1;
};

/// A thread that calls `work` after every pause until this object is destroyed. After an exception,
/// for want of memory, it calls again after the pause. `name` is the thread's in ps and top.
class Periodic {
 public:
  using Work = std::function<void(const std::stop_token& stop)>;
  Periodic(const char* name, std::chrono::milliseconds pause, Work work);

 private:
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

/// Gives every thread that starts after this call a stack of at least 8 MiB, whatever `ulimit -s`
/// is: twice Eigen's largest array on the stack (EIGEN_STACK_ALLOCATION_LIMIT).
void enlarge_thread_stacks();

/// Returns how many descriptors this process may open.
std::size_t descriptor_limit();

/// Raises the process's soft limit of descriptors (RLIMIT_NOFILE) to the hard one.
void raise_descriptor_limit();

/// The descriptors that a process needs beside its connections: listeners, epoll sets, event
/// descriptors of gRPC's threads, the store, logs.
inline constexpr std::size_t reserved_descriptors = 96;

}  // namespace stiefel::server
