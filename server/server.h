#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/access/access_options.h"
#include "server/scheduling/quota.h"
#include "server/sessions/principal.h"
#include "server/store/store_options.h"

namespace grpc {
class CallbackServerContext;
}

namespace stiefel::server {

/// How connections to the addresses are kept.
struct ConnectionOptions {
  /// At once; 0: as many as the process's limit of descriptors leaves, which also caps it.
  std::size_t most = 0;
  /// A connection that has not sent a byte for so long after it was made is closed, and one that
  /// has not finished HTTP/2's handshake.
  std::chrono::milliseconds patience = std::chrono::seconds(10);
  /// An older connection takes no new calls and ends with its last one; 0: none is too old.
  std::chrono::milliseconds max_age = std::chrono::milliseconds(0);
  /// Calls of one connection at once. A client of gRPC keeps further calls back until one ends.
  int calls = 2000;
  /// The server pings a connection on which nothing came for `keepalive`, and closes it when
  /// nothing comes for `keepalive_timeout` either.
  std::chrono::milliseconds keepalive = std::chrono::seconds(20);
  std::chrono::milliseconds keepalive_timeout = std::chrono::seconds(10);
  /// A client that pings more often, three times in a row, loses its connection.
  std::chrono::milliseconds least_ping_interval = std::chrono::seconds(9);
  /// The server connects to its own addresses, and calls `unreachable` when one has not answered
  /// for so long; 0: it does not.
  std::chrono::milliseconds self_watch = std::chrono::milliseconds(0);
  std::function<void()> unreachable = {};
};

struct Options {
  /// Where to listen: "127.0.0.1:50551", "[::1]:0" (any free port), "unix:/run/s.sock". None: only
  /// `in_process_channel`.
  std::vector<std::string> listen = {};
  /// Threads that compute; 0 means one a core.
  int threads = 0;
  std::uint32_t max_sessions = 1000;
  /// Bytes that the process may take; 0: three quarters of what the control group or the machine
  /// has. Sessions, calls and messages that do not fit are refused with RESOURCE_EXHAUSTED.
  std::uint64_t memory = 0;
  /// A session without a call for this time is dropped.
  std::chrono::milliseconds idle_timeout = std::chrono::hours(1);
  /// How long `shutdown` lets running work finish before it stops it.
  std::chrono::milliseconds grace = std::chrono::seconds(3);
  /// trace, debug, info, warn, error, critical, off. One line an RPC at info, on stderr.
  std::string log_level = "warn";
  bool log_json = false;
  /// Where metrics are served over HTTP, host:port; empty: there are none.
  std::string metrics = {};
  ConnectionOptions connections = {};
  AccessOptions access = {};
  /// Where sessions outlive the process; without a file they live in memory.
  StoreOptions store = {};
  /// The limits of each principal.
  Quota quota = {};
  /// For tests: who calls; by the caller's token when empty.
  std::function<Principal(const grpc::CallbackServerContext&)> identify = {};
  /// For tests; the steady clock when empty.
  std::function<std::chrono::steady_clock::time_point()> clock = {};
};

/// The whole service: sessions, the threads that compute, health, reflection. `stiefel-server` is
/// one of these; a program can hold its own. Thread-safe.
class Server {
 public:
  /// Throws std::runtime_error when an address is none (address.h), cannot be listened on
  /// (transport/listener.h) or is one that other machines reach, without TLS and not `insecure`
  /// (for metrics: metrics/exporter.h);
  /// for files that do not hold what they must (access/); and when the store cannot be used
  /// (store/store_file.h).
  explicit Server(Options options);
  /// Shuts down, without grace if `shutdown` was not called.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// What a client connects to, in the order of `Options::listen`, with the port that was chosen.
  const std::vector<std::string>& addresses() const;

  /// Where the metrics are read, "http://127.0.0.1:9464/metrics"; empty without `Options::metrics`.
  std::string metrics_url() const;

  /// A channel that needs no address. It must not be used after the server is gone.
  std::shared_ptr<grpc::Channel> in_process_channel();

  /// Not serving at once: new work is refused with UNAVAILABLE. What runs may finish within the
  /// grace period; then Steps end with OUTCOME_CANCELLED and their last good state, and streams
  /// with a last message that says so. Returns when nothing runs. Calling it again does nothing.
  void shutdown();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stiefel::server
