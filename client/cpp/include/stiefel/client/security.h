#pragma once

#include <optional>
#include <string>

namespace stiefel::client {

/// Files in PEM.
struct Tls {
  /// The authorities of the server's certificate; empty: those of the system.
  std::string ca = {};
  /// This client's certificate and its key, for a server that asks for one; both or none.
  std::string certificate = {}, key = {};
  /// The name that the server's certificate must have; empty: the host of the address.
  std::string name = {};
};

/// How a channel is secured.
struct Security {
  /// Nothing: no TLS.
  std::optional<Tls> tls = std::nullopt;
  /// Tells the server who calls; empty: the environment variable STIEFEL_TOKEN, if it is set. It is
  /// sent over TLS, to this machine or over a Unix socket only.
  std::string token = {};
};

/// The first line of a file, without the spaces around it. Throws Error of the code
/// INVALID_ARGUMENT where the file cannot be read.
std::string read_token(const std::string& path);

}  // namespace stiefel::client
