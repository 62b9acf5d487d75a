#include "client/cli/endpoint.h"

#include "client/cli/interrupt.h"
#include "client/cli/progress/status_line.h"

namespace stiefel::cli {
namespace {

std::unique_ptr<server::Server> embed() {
  server::Options options;
  options.log_level = "error";
  return std::make_unique<server::Server>(std::move(options));
}

client::Options options(const Remote& remote) {
  client::Options options;
  options.stop = interruption();
  // A Unix socket has no TLS, even if the environment names authorities.
  if (!remote.tls_ca.empty() && !remote.address.starts_with("unix:"))
    options.security.tls = client::Tls{.ca = remote.tls_ca};
  if (!remote.token_file.empty()) options.security.token = client::read_token(remote.token_file);
  return options;
}

}  // namespace

Endpoint::Endpoint(const Remote& remote)
    : embedded_(remote.address.empty() ? embed() : nullptr),
      client_(embedded_ ? client::Client(embedded_->in_process_channel(), options(remote))
                        : client::Client::connect(remote.address, options(remote))) {}

client::Session Endpoint::create(const v1::Scene& scene) const {
  const ElapsedLine line(scene.has_tolerance() ? "choosing a method" : "creating the session");
  return client_.create(scene);
}

}  // namespace stiefel::cli
