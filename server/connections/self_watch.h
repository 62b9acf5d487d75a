#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/connections/listener.h"
#include "server/scheduling/process.h"

namespace stiefel::server {

/// Returns the first bytes that a TLS client offering HTTP/2 sends, which a live server answers.
/// Empty if OpenSSL fails.
std::string client_hello();

/// Whether a connection to `address` that sends `hello` is answered within `timeout` by nine bytes,
/// the length of the header of HTTP/2's first frame. An empty `hello` means HTTP/2's preface.
/// Returns true if this process gets no socket, which proves nothing about the server.
bool answers(const SocketAddress& address, std::chrono::milliseconds timeout,
             std::string_view hello = {});

/// Connects to the server's own addresses from a thread of its own, which load on other threads
/// does not delay. Calls `give_up` once when an address has not answered for `patience`.
class SelfWatch {
 public:
  /// `tls_hello` is sent to all addresses but Unix sockets; empty if the server has no TLS.
  SelfWatch(std::vector<SocketAddress> addresses, std::chrono::milliseconds patience,
            std::function<void()> give_up, std::string tls_hello = {});

 private:
  void look(const std::stop_token& stop);

  const std::vector<SocketAddress> addresses_;
  const std::chrono::milliseconds patience_;
  const std::function<void()> give_up_;
  const std::string tls_hello_;
  std::vector<std::chrono::steady_clock::time_point> answered_;  // the last time, of each address
  bool given_up_ = false;
  Periodic thread_;
};

}  // namespace stiefel::server
