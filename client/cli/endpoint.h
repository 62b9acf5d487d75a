#pragma once

#include <memory>
#include <string>

#include "server/server.h"
#include "stiefel/client/client.h"

namespace stiefel::cli {

struct Remote {
  std::string address = {};     ///< empty: the command embeds a server
  std::string tls_ca = {};      ///< path of a file of authorities; empty: no TLS
  std::string token_file = {};  ///< path of a file; empty: the variable STIEFEL_TOKEN
};

/// The server that a command talks to: the one at the given address, or one inside this process.
class Endpoint {
 public:
  explicit Endpoint(const Remote& remote);
  const client::Client& client() const { return client_; }

  /// Creates a session of the scene. The choice of a method for a tolerance may take seconds, in
  /// which a status line is shown.
  client::Session create(const v1::Scene& scene) const;

 private:
  std::unique_ptr<server::Server> embedded_;
  client::Client client_;
};

}  // namespace stiefel::cli
