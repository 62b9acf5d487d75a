#include "server/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <atomic>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "engine/simulation/run/ensemble.h"
#include "server/address.h"
#include "server/calls/limits.h"
#include "server/calls/service.h"

namespace stiefel::server {
namespace {

// What running calls get to deliver their last message.
constexpr auto delivery_time = std::chrono::milliseconds(500);

std::string with_port(const std::string& address, int port) {
  if (address.starts_with("unix:")) return address;
  return address.substr(0, address.rfind(':') + 1) + std::to_string(port);
}

}  // namespace

struct Server::Parts {
  explicit Parts(const Options& options)
      : grace(options.grace),
        host{Log(options.log_level, options.log_json),
             Registry(options.max_sessions, options.idle_timeout, options.clock), Lifecycle(),
             Pool(options.threads), Pool(options.threads)},
        service(host),
        sweeper(host.registry, [this](std::size_t dropped) {
          host.log.line(Log::Level::info, "sessions expired",
                        {{"count", static_cast<std::int64_t>(dropped)}});
        }) {}

  const std::chrono::milliseconds grace;
  Host host;
  Service service;
  Sweeper sweeper;
  std::vector<std::string> addresses;
  std::unique_ptr<grpc::Server> grpc;
  std::once_flag shut_down;
};

Server::Server(Options options) : parts_(std::make_unique<Parts>(options)) {
  if (options.threads > 0) limit_ensemble_threads(options.threads);
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  builder.SetMaxReceiveMessageSize(static_cast<int>(max_message_bytes));
  // Otherwise a second server on the same port would share its connections.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  std::vector<int> ports(options.listen.size());
  // gRPC takes ports beyond 65535 modulo 65536.
  for (const std::string& address : options.listen)
    if (const auto fault = address_fault(address))
      throw std::runtime_error("cannot listen on " + address + ": " + *fault);
  for (std::size_t i = 0; i < ports.size(); ++i) {
    builder.AddListeningPort(options.listen[i], grpc::InsecureServerCredentials(), &ports[i]);
  }
  builder.RegisterService(&parts_->service);
  parts_->grpc = builder.BuildAndStart();
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (!parts_->grpc || ports[i] == 0) {
      throw std::runtime_error("cannot listen on " + options.listen[i]);
    }
    parts_->addresses.push_back(with_port(options.listen[i], ports[i]));
    parts_->host.log.line(Log::Level::info, "listening", {{"address", parts_->addresses.back()}});
  }
  if (!parts_->grpc) throw std::runtime_error("cannot start the server");
  parts_->grpc->GetHealthCheckService()->SetServingStatus(
      v1::SimulationService::service_full_name(), true);
}

Server::~Server() {
  if (!parts_->grpc) return;
  parts_->host.lifecycle.stop();
  shutdown();
}

const std::vector<std::string>& Server::addresses() const { return parts_->addresses; }

std::shared_ptr<grpc::Channel> Server::in_process_channel() {
  return parts_->grpc->InProcessChannel(grpc::ChannelArguments());
}

void Server::shutdown() {
  std::call_once(parts_->shut_down, [this] {
    Host& host = parts_->host;
    parts_->grpc->GetHealthCheckService()->Shutdown();
    host.lifecycle.refuse();
    host.log.line(Log::Level::info, "shutting down");
    if (!host.lifecycle.stopping()) host.lifecycle.wait_idle(parts_->grace);
    host.lifecycle.stop();
    // The in-process transport closes at once and would drop the last messages.
    host.lifecycle.wait_idle(delivery_time);
    parts_->grpc->Shutdown(std::chrono::system_clock::now() + delivery_time);
    host.lifecycle.wait_idle(std::chrono::hours(1));
    host.log.line(Log::Level::info, "stopped");
  });
}

}  // namespace stiefel::server
