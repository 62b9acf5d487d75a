#include "client/cli/endpoint.h"

#include "client/cli/exit_status.h"
#include "server/address.h"

namespace stiefel::cli {
namespace {

std::unique_ptr<server::Server> embed() {
  server::Options options;
  options.log_level = "error";
  return std::make_unique<server::Server>(std::move(options));
}

/// gRPC takes ports beyond 65535 modulo 65536, and waits for what is no address.
const std::string& sound(const std::string& address) {
  if (const auto fault = server::address_fault(address); fault && !address.empty())
    throw BadInput("--server: " + address + ": " + *fault);
  return address;
}

}  // namespace

Endpoint::Endpoint(const std::string& address)
    : embedded_(address.empty() ? embed() : nullptr),
      client_(embedded_ ? client::Client(embedded_->in_process_channel())
                        : client::Client::connect(sound(address))) {}

}  // namespace stiefel::cli
