#pragma once

#include <string>

#include "server/connections/access_options.h"

namespace stiefel::server {

/// What `stiefel-server healthcheck` asks, and how it connects.
struct HealthCheck {
  std::string address = {};
  std::string service = {};  ///< full name; empty: the whole server
  /// File of the authorities of the server's certificate. Empty: any certificate is accepted, since
  /// neither question nor answer is secret.
  std::string ca = {};
  TlsFiles tls = {};  ///< the server's own, shown where clients need a certificate
};

/// Asks the standard health service and writes the answer to stderr. Returns 0 if the service
/// answers SERVING within 2 s, otherwise 1. Sends no token.
int health_check(const HealthCheck& question);

}  // namespace stiefel::server
