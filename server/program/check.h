#pragma once

#include <string>

#include "server/connections/access_options.h"
#include "server/server.h"

namespace stiefel::server {

/// Returns how many threads a server with these options starts at most at once, without those that
/// gRPC adds under load.
int threads_of(const Options& options);

/// Checks whether a server could start with these options: listens on its addresses with other
/// ports, reads the store's header, and makes a server without them. Writes each fault as a line on
/// stderr. Returns the exit status, 0 if there is no fault. Does not disturb a running
/// server.
int check(const Options& options);

/// What `stiefel-server healthcheck` asks, and how it connects.
struct HealthCheck {
  std::string address = {};
  std::string service = {};  ///< full name; empty: the whole server
  std::string ca = {};       ///< file of the authorities of the server's certificate; may be empty
  TlsFiles tls = {};         ///< the server's own, shown where clients need a certificate
};

/// Asks the standard health service and writes the answer to stderr. Returns 0 if the service
/// answers SERVING within 2 s, otherwise 1. Sends no token.
int health_check(const HealthCheck& question);

}  // namespace stiefel::server
