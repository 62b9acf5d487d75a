#pragma once

#include <signal.h>

#include <atomic>
#include <chrono>
#include <latch>

namespace stiefel::server {

/// Waits for the signal that ends a server, SIGTERM or SIGINT, from before the server is made. A
/// server that is still starting, which may take long with a large store, has promised nothing: the
/// signal then ends the process at once, with status 0. After the signal the process ends in any
/// case, `grace` and two seconds later. Lives as long as the process.
class EndSignal {
 public:
  /// Blocks the signals, so that every thread made later leaves them to this object. Call it before
  /// there are other threads.
  explicit EndSignal(std::chrono::milliseconds grace);
  EndSignal(const EndSignal&) = delete;
  EndSignal& operator=(const EndSignal&) = delete;

  /// From now on the signal makes `wait` return. Does not return if the process is ending.
  void started() {
    if (!starting_.exchange(false)) pause();
  }
  /// Returns after the signal.
  void wait() { received_.wait(); }
  /// Says what the shutdown waits for, a string literal, for the message of a shutdown that takes
  /// too long.
  void waits_for(const char* what) { waits_for_ = what; }
  /// Ends the process silently within half a second, for gRPC, which waits at exit for up to 10 s
  /// until the last of its objects is gone.
  static void exit_soon();

 private:
  void receive();
  /// Ends the process with status 0 after the grace period, and says what it no longer waits for.
  void exit_in_time();

  const std::chrono::milliseconds grace_;
  sigset_t signals_;
  std::atomic<bool> starting_ = true;
  std::atomic<const char*> waits_for_ = "the signal's handling";
  std::latch received_{1};
};

}  // namespace stiefel::server
