#include "server/server.h"

#include <absl/synchronization/mutex.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <sys/socket.h>

#include <algorithm>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "server/calls/durability.h"
#include "server/calls/gate.h"
#include "server/calls/health_service.h"
#include "server/calls/service.h"
#include "server/connections/acceptor.h"
#include "server/connections/callers.h"
#include "server/connections/certificates.h"
#include "server/connections/exporter.h"
#include "server/connections/listener.h"
#include "server/connections/log.h"
#include "server/connections/metrics.h"
#include "server/connections/reflection_limit.h"
#include "server/scheduling/memory_limit.h"
#include "server/scheduling/process.h"
#include "server/sessions/store/store_file.h"

namespace stiefel::server {
namespace {

// The time that running calls get to end their slices, that to end one decomposition of a large
// matrix, and that to deliver their last message: together less than 2 s.
constexpr auto slice_time = std::chrono::milliseconds(100);
constexpr auto decomposition_time = std::chrono::milliseconds(1200);
constexpr auto delivery_time = std::chrono::milliseconds(500);

std::string with_port(const std::string& address, int port) {
  if (address.starts_with("unix:")) return address;
  return address.substr(0, address.rfind(':') + 1) + std::to_string(port);
}

void check_address(const std::string& address, const AccessOptions& access) {
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error("cannot listen on " + address + ": " + why);
  };
  if (const auto fault = address_fault(address)) refuse(*fault);
  if (!access.tls.given() && !access.insecure && is_exposed(address))
    refuse("other machines can reach it: give --tls-cert and --tls-key, or --insecure");
}

bool is_unix_socket(int connection) {
  int domain = 0;
  socklen_t size = sizeof domain;
  return getsockopt(connection, SOL_SOCKET, SO_DOMAIN, &domain, &size) == 0 && domain == AF_UNIX;
}

std::vector<std::string> method_names() {
  const auto* service =
      google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(service_name);
  std::vector<std::string> names;
  for (int i = 0; i < service->method_count(); ++i) names.push_back(service->method(i)->name());
  return names;
}

int milliseconds(std::chrono::milliseconds time) {
  return static_cast<int>(std::min<std::int64_t>(time.count(), std::numeric_limits<int>::max()));
}

void keep_connections(const ConnectionOptions& options, grpc::ServerBuilder& builder) {
  const auto set = [&](const char* name, int value) { builder.AddChannelArgument(name, value); };
  set(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, milliseconds(options.patience));
  if (options.max_age.count() > 0)
    set(GRPC_ARG_MAX_CONNECTION_AGE_MS, milliseconds(options.max_age));
  set(GRPC_ARG_MAX_CONCURRENT_STREAMS, options.calls);
  set(GRPC_ARG_KEEPALIVE_TIME_MS, milliseconds(options.keepalive));
  set(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, milliseconds(options.keepalive_timeout));
  set(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  // Otherwise the third ping without data in between would be delayed, and the keepalive with it.
  set(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  set(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
      milliseconds(options.least_ping_interval));
}

/// Limits the memory of what gRPC is receiving: beyond its share, gRPC ends first idle connections
/// and then calls, with RESOURCE_EXHAUSTED.
void limit_memory(std::uint64_t memory, grpc::ServerBuilder& builder) {
  // Some calls more than are let in, so that the others are refused with a reason.
  constexpr int most_threads = most_calls + 100;
  grpc::ResourceQuota quota("stiefel");
  quota.Resize(grpc_share(memory));
  quota.SetMaxThreads(most_threads);
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(static_cast<int>(largest_message(memory)));
}

/// Refuses compressed messages, because gRPC 1.51 inflates a message before it compares its size
/// with the limit: 4 MB become 4 GB. A call with such messages ends with UNIMPLEMENTED.
void refuse_compression(grpc::ServerBuilder& builder) {
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
}

int threads_of(const Options& options) {
  if (options.threads > 0) return options.threads;
  return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

std::uint64_t memory_limit_of(const Options& options) {
  return options.memory > 0 ? options.memory : default_memory();
}

}  // namespace

Quota limits_of_principals(const Options& options) {
  return with_shares(options.quota, !options.access.tokens.empty(), options.max_sessions,
                     session_share(memory_limit_of(options)));
}

struct Server::Parts {
  explicit Parts(const Options& options)
      : grace(options.grace),
        memory_limit(memory_limit_of(options)),
        quota(limits_of_principals(options)),
        host{Log(options.log_level, options.log_json),
             memory_limit,
             MemoryBudget(session_share(memory_limit)),
             Accounts(quota, host.memory,
                      [this](const Principal& principal, std::uint64_t bytes) {
                        host.registry.evict(bytes, &principal);
                      }),
             Registry(options.max_sessions, options.idle_timeout, options.clock, host.memory),
             Lifecycle(),
             options.identify,
             options.metrics.empty() ? nullptr : std::make_unique<CallMetrics>(method_names()),
             threads_of(options)},
        health(service_name),
        durability(options.store.empty()
                       ? nullptr
                       : std::make_unique<Durability>(
                             options.store, host, [this](bool able) { health.set_able(able); })),
        sweeper("sweep", host.registry.sweep_interval(), [this](const auto&) {
          if (const std::size_t dropped = host.registry.expire())
            host.log.line(Log::Level::info, "sessions expired",
                          {{"count", static_cast<std::int64_t>(dropped)}});
          give_back_freed_memory(host.memory.used(), host.memory.limit());
        }) {
    if (options.access.tls.given()) certificates.emplace(options.access.tls, host.log);
    if (!options.access.tokens.empty()) {
      host.log.line(Log::Level::info, "limits of a principal",
                    {{"sessions", static_cast<std::int64_t>(*quota.sessions)},
                     {"memory_bytes", static_cast<std::int64_t>(*quota.memory)}});
      callers.emplace(options.access.tokens, host.log);
    }
    host.description = description(host);
    gate.emplace(host, callers ? &*callers : nullptr);
  }

  void listen(const std::vector<std::string>& at, const AccessOptions& access);
  void accept();

  const std::chrono::milliseconds grace;
  const std::uint64_t memory_limit;
  const Quota quota;
  Host host;
  HealthService health;
  std::unique_ptr<Durability> durability;  // null if sessions live in memory
  std::optional<ServedCertificates> certificates;
  std::optional<Callers> callers;
  std::optional<Gate> gate;
  Periodic sweeper;
  std::optional<Exporter> exporter;
  std::vector<std::string> addresses;
  std::vector<Listener> listeners;  // until the acceptor takes them
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections, tls_connections;
  std::unique_ptr<grpc::Server> grpc;
  std::optional<Acceptor> acceptor;
  std::once_flag shut_down;
};

void Server::Parts::listen(const std::vector<std::string>& at, const AccessOptions& access) {
  for (const std::string& address : at) {
    check_address(address, access);
    auto some = listen_on(address);
    addresses.push_back(with_port(address, some.front().port));
    for (Listener& one : some) listeners.push_back(std::move(one));
  }
}

void Server::Parts::accept() {
  if (listeners.empty()) return;
  const std::size_t limit = descriptor_limit();
  const int most =
      static_cast<int>(limit > reserved_descriptors ? limit - reserved_descriptors : 1);
  acceptor.emplace(
      std::move(listeners), most,
      [this](int connection) {
        grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
        parameters.fd = connection;
        const bool encrypted = tls_connections && !is_unix_socket(connection);
        (encrypted ? tls_connections : connections)->HandleNewConnection(&parameters);
      },
      host.log);
  for (const std::string& address : addresses)
    host.log.line(Log::Level::info, "listening",
                  {{"address", address}, {"descriptors", static_cast<std::int64_t>(most)}});
}

Server::Server(Options options) {
  enlarge_thread_stacks();
  // Debian 13 has abseil with its search for deadlocks, which aborts at a cycle in the order in
  // which locks were ever taken. Locks of gRPC have such cycles without a deadlock.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  parts_ = std::make_unique<Parts>(options);
  parts_->listen(options.listen, options.access);
  if (!options.metrics.empty()) {
    const Host& host = parts_->host;
    parts_->exporter.emplace(
        options.metrics, options.access.insecure,
        Exporter::Parts{*host.metrics, host.registry, host.turns, host.memory, host.threads});
    host.log.line(Log::Level::info, "metrics", {{"url", parts_->exporter->url()}});
  }
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  builder.experimental().SetInterceptorCreators(ReflectionLimit::interceptors());
  limit_memory(parts_->memory_limit, builder);
  keep_connections(options.connections, builder);
  refuse_compression(builder);
  using Builder = grpc::ServerBuilder::experimental_type;
  parts_->connections = builder.experimental().AddExternalConnectionAcceptor(
      Builder::ExternalConnectionType::FROM_FD, grpc::InsecureServerCredentials());
  if (parts_->certificates)
    parts_->tls_connections = builder.experimental().AddExternalConnectionAcceptor(
        Builder::ExternalConnectionType::FROM_FD, parts_->certificates->credentials());
  builder.SetSyncServerOption(grpc::ServerBuilder::MAX_POLLERS, 8);
  builder.RegisterService(&*parts_->gate);
  builder.RegisterService(&parts_->health);
  parts_->grpc = builder.BuildAndStart();
  if (!parts_->grpc) throw std::runtime_error("cannot start the server");
  parts_->accept();
}

Server::~Server() {
  if (!parts_->grpc) return;
  parts_->host.lifecycle.stop();
  shutdown();
}

const std::vector<std::string>& Server::addresses() const { return parts_->addresses; }

std::string Server::metrics_url() const { return parts_->exporter ? parts_->exporter->url() : ""; }

std::shared_ptr<grpc::Channel> Server::in_process_channel() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  return parts_->grpc->InProcessChannel(arguments);
}

void Server::shutdown() {
  std::call_once(parts_->shut_down, [this] {
    Host& host = parts_->host;
    host.lifecycle.refuse();
    parts_->health.stop();
    host.log.line(Log::Level::info, "shutting down");
    if (!host.lifecycle.stopping()) host.lifecycle.wait_idle(parts_->grace);
    host.lifecycle.stop();
    host.lifecycle.wait_idle(slice_time);
    host.lifecycle.interrupt();
    // The in-process transport closes at once and would drop the last messages.
    host.lifecycle.wait_idle(decomposition_time);
    parts_->acceptor.reset();
    parts_->grpc->Shutdown(std::chrono::system_clock::now() + delivery_time);
    host.lifecycle.wait_idle(std::chrono::hours(1));
    host.log.line(Log::Level::info, "stopped");
  });
}

void check(Options options) {
  for (const std::string& address : options.listen) check_address(address, options.access);
  if (!options.metrics.empty()) check_exporter(options.metrics, options.access.insecure);
  if (const auto fault = store_fault(options.store)) throw std::runtime_error("--store: " + *fault);
  options.listen.clear();
  options.metrics.clear();
  options.store.clear();
  options.log_level = "warn";
  const Server server(options);
}

}  // namespace stiefel::server
