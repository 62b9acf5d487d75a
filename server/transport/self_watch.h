#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "server/transport/listener.h"

namespace stiefel::server {

/// A connection to `address` is answered: HTTP/2's first frame of nine bytes comes back in time.
/// Where this process gets no socket that proves nothing, and counts as answered.
bool answers(const SocketAddress& address, std::chrono::milliseconds timeout);

/// Connects to the server's own addresses from a thread that does nothing else, so that load does
/// not trigger it. `give_up` is called once when an address has not answered for `patience`.
class SelfWatch {
 public:
  SelfWatch(std::vector<SocketAddress> addresses, std::chrono::milliseconds patience,
            std::function<void()> give_up);

 private:
  void run(const std::stop_token& stop);

  const std::vector<SocketAddress> addresses_;
  const std::chrono::milliseconds patience_;
  const std::function<void()> give_up_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

}  // namespace stiefel::server
