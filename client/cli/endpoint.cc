#include "client/cli/endpoint.h"

#include "client/cli/interrupt.h"

namespace stiefel::cli {
namespace {

std::unique_ptr<server::Server> embed() {
  server::Options options;
  options.log_level = "error";
  return std::make_unique<server::Server>(std::move(options));
}

client::Options options() {
  client::Options options;
  options.stop = interruption();
  return options;
}

}  // namespace

Endpoint::Endpoint(const std::string& address)
    : embedded_(address.empty() ? embed() : nullptr),
      client_(embedded_ ? client::Client(embedded_->in_process_channel(), options())
                        : client::Client::connect(address, options())) {}

}  // namespace stiefel::cli
