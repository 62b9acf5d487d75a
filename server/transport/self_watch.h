#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/transport/listener.h"

namespace stiefel::server {

/// A connection to `address` that sends `hello` is answered: nine bytes, HTTP/2's first frame, come
/// back in time. An empty `hello` is HTTP/2's preface. Where this process gets no socket that
/// proves nothing, and counts as answered.
bool answers(const SocketAddress& address, std::chrono::milliseconds timeout,
             std::string_view hello = {});

/// Connects to the server's own addresses from a thread that does nothing else, so that load does
/// not trigger it. `give_up` is called once when an address has not answered for `patience`.
class SelfWatch {
 public:
  /// `tls_hello`: sent to all but Unix sockets; empty where the server has no TLS.
  SelfWatch(std::vector<SocketAddress> addresses, std::chrono::milliseconds patience,
            std::function<void()> give_up, std::string tls_hello = {});

 private:
  void run(const std::stop_token& stop);

  const std::vector<SocketAddress> addresses_;
  const std::chrono::milliseconds patience_;
  const std::function<void()> give_up_;
  const std::string tls_hello_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

}  // namespace stiefel::server
