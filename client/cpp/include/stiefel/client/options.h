#pragma once

#include <chrono>
#include <optional>
#include <stop_token>
#include <string>

namespace stiefel::client {

/// Paths of PEM files for TLS, and the server's name.
struct Tls {
  /// The authorities that may sign the server's certificate; empty: those of the system.
  std::string ca = {};
  /// This client's certificate and its key, for a server that asks for one; give both or none.
  std::string certificate = {}, key = {};
  /// The name that the server's certificate must have; empty: the host of the address.
  std::string name = {};
};

/// How `Client::connect` makes a connection, and what holds for its calls.
struct Options {
  /// Without a value the connection has no TLS.
  std::optional<Tls> tls = std::nullopt;
  /// Tells the server who calls. Empty: the value of the environment variable STIEFEL_TOKEN, if it
  /// is set. The token is sent only over TLS, to this machine, or over a Unix socket.
  std::string token = {};
  /// The most time of a call, with its repetitions; for a stream, until its last message. None by
  /// default, because only the caller knows the length of a run. A Drive has no limit.
  std::optional<std::chrono::milliseconds> timeout = std::nullopt;
  /// A stop request cancels all running and later calls except the deletion of a session; the
  /// cancelled calls throw Error with the code CANCELLED.
  std::stop_token stop = {};
};

/// Returns the first word of a file. Throws Error with the code INVALID_ARGUMENT if the file is
/// empty or cannot be read.
std::string read_token(const std::string& path);

}  // namespace stiefel::client
