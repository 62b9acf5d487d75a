#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/connections/access_options.h"
#include "server/scheduling/principal.h"

namespace grpc {
class ServerContextBase;
}

namespace stiefel::server {

/// How the server treats its connections.
struct ConnectionOptions {
  /// The time after which a connection is closed that has not finished HTTP/2's handshake.
  std::chrono::milliseconds patience = std::chrono::seconds(10);
  /// The age at which a connection takes no new calls and ends with its last one; 0 means never.
  std::chrono::milliseconds max_age = std::chrono::milliseconds(0);
  /// The calls of one connection at once. A client of gRPC holds further calls back until one ends.
  int calls = 2000;
  /// The server pings a connection on which nothing came for `keepalive`, and closes it if nothing
  /// comes for a further `keepalive_timeout`.
  std::chrono::milliseconds keepalive = std::chrono::seconds(15);
  std::chrono::milliseconds keepalive_timeout = std::chrono::seconds(10);
  /// A client that pings more often than this three times in a row loses its connection.
  std::chrono::milliseconds least_ping_interval = std::chrono::seconds(9);
};

struct Options {
  /// Where to listen: "127.0.0.1:50551", "[::1]:0" (any free port), "unix:/run/s.sock". Without an
  /// address, only `in_process_channel` connects.
  std::vector<std::string> listen = {};
  /// The threads that compute; 0 means one a core.
  int threads = 0;
  std::uint32_t max_sessions = 1000;
  /// The bytes that the process may take; 0 means three quarters of what the control group or the
  /// machine has. Sessions, calls and messages that do not fit are refused with RESOURCE_EXHAUSTED.
  std::uint64_t memory = 0;
  /// The time without a call after which a session is dropped.
  std::chrono::milliseconds idle_timeout = std::chrono::hours(1);
  /// The time that `shutdown` gives running work to finish before it stops it.
  std::chrono::milliseconds grace = std::chrono::seconds(3);
  /// trace, debug, info, warn, error, critical, off, on stderr. At info one line for an RPC that
  /// fails or takes 10 ms, at debug for every RPC.
  std::string log_level = "warn";
  bool log_json = false;
  /// The host:port on which metrics are served over plain HTTP; empty means no metrics.
  std::string metrics = {};
  ConnectionOptions connections = {};
  AccessOptions access = {};
  /// The file of the store in which sessions outlive the process; empty: they live in memory.
  std::string store = {};
  /// The limits of each principal; see `limits_of_principals`.
  Quota quota = {};
  /// For tests: returns who calls; if empty, the caller's token decides.
  std::function<Principal(const grpc::ServerContextBase&)> identify = {};
  /// For tests: the clock; the steady clock if empty.
  std::function<std::chrono::steady_clock::time_point()> clock = {};
};

/// Returns the limits of each principal with which a server of these options runs. With tokens
/// there may be several principals.
Quota limits_of_principals(const Options& options);

/// The whole service: sessions, the threads that compute, health, reflection. `stiefel-server` runs
/// one; a program can embed its own. Thread-safe.
class Server {
 public:
  /// Throws std::runtime_error when an address is not valid, cannot be listened on
  /// or can be reached by other machines without TLS and `insecure`; when a file does not hold what
  /// it must; and when the store cannot be used.
  explicit Server(Options options);
  /// Shuts down, without a grace period if `shutdown` was not called.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The addresses to which clients connect, in the order of `Options::listen`, with the chosen
  /// ports.
  const std::vector<std::string>& addresses() const;

  /// The URL of the metrics, "http://127.0.0.1:9464/metrics"; empty without `Options::metrics`.
  std::string metrics_url() const;

  /// Returns a channel that needs no address. It must not be used after the server is destroyed.
  std::shared_ptr<grpc::Channel> in_process_channel();

  /// Stops serving: refuses new work with UNAVAILABLE at once. Running work may finish within the
  /// grace period; after that, every call ends with UNAVAILABLE and what checkpoint it has. Returns
  /// when nothing runs. Further calls do nothing.
  void shutdown();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Throws std::runtime_error with the reason if a server could not start with these options.
/// Neither listens nor opens the store, which a server that runs holds.
void check(Options options);

}  // namespace stiefel::server
