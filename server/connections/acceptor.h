#pragma once

#include <chrono>
#include <functional>
#include <thread>
#include <vector>

#include "server/connections/listener.h"
#include "server/connections/log.h"

namespace stiefel::server {

/// Accepts connections on a thread of its own and gives each one away. It goes on accepting after
/// the process was out of descriptors or memory, which gRPC's own listener does not.
class Acceptor {
 public:
  /// Takes over a non-blocking connection and closes it in the end.
  using GiveAway = std::function<void(int connection)>;

  /// Closes a connection at once whose descriptor is `most` or more: the kernel gives the smallest
  /// free number. Logs at most once a second how many it closed.
  Acceptor(std::vector<Listener> listeners, int most, GiveAway give_away, const Log& log);
  /// Stops listening and removes the files of Unix sockets.
  ~Acceptor();
  Acceptor(const Acceptor&) = delete;
  Acceptor& operator=(const Acceptor&) = delete;

 private:
  void run(const std::stop_token& stop);
  /// Returns false if the process has no descriptor or no memory for a connection that waits.
  bool accept_from(int listener);
  void refuse();

  const std::vector<Listener> listeners_;
  const int most_;
  const GiveAway give_away_;
  const Log& log_;
  std::chrono::steady_clock::time_point reported_{};
  std::int64_t refused_ = 0;
  std::jthread thread_;
};

}  // namespace stiefel::server
