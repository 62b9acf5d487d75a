#pragma once

#include <memory>

#include "client/cli/commands.h"
#include "server/server.h"
#include "stiefel/client/client.h"

namespace stiefel::cli {

/// The server that a command talks to: the one at the given address, or one inside this process.
class Endpoint {
 public:
  explicit Endpoint(const Remote& remote);
  const client::Client& client() const { return client_; }

 private:
  std::unique_ptr<server::Server> embedded_;
  client::Client client_;
};

}  // namespace stiefel::cli
