#pragma once

#include <string>

#include "server/access/access_options.h"

namespace stiefel::server {

/// What `stiefel-server healthcheck` asks, and how it connects.
struct HealthCheck {
  std::string address = "127.0.0.1:50551";  ///< of a list, separated by commas, the first
  std::string service = {};                 ///< full name; empty: the whole server
  std::string ca = {};  ///< file of the authorities of the server's certificate; may be empty
  TlsFiles tls = {};    ///< the server's own, which it shows where clients need a certificate
};

/// Exit status 0 when the standard health service answers SERVING within 2 s, else 1; says on
/// stderr what it found. It sends no token.
int health_check(const HealthCheck& question);

}  // namespace stiefel::server
