#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <set>
#include <string>

#include "grpc/health/v1/health.grpc.pb.h"

namespace stiefel::server {

/// The standard health service, which needs no token. Unlike gRPC's own it limits the open Watches,
/// each of which takes about 20 KB: further ones end with RESOURCE_EXHAUSTED. Thread-safe.
class HealthService final : public grpc::health::v1::Health::CallbackService {
 public:
  /// The most Watches of one connection; those of all Unix sockets together count as one.
  static constexpr std::size_t most_of_connection = 16;
  /// Returns the most Watches of a server with `memory` bytes: a sixty-fourth of them, at least 64.
  static std::size_t most_watches(std::uint64_t memory);

  /// `service`: the full name of the service that is healthy beside the server itself.
  HealthService(std::string service, std::size_t most_watches);

  using Context = grpc::CallbackServerContext;
  using Request = grpc::health::v1::HealthCheckRequest;
  using Response = grpc::health::v1::HealthCheckResponse;
  grpc::ServerUnaryReactor* Check(Context*, const Request*, Response*) override;
  grpc::ServerWriteReactor<Response>* Watch(Context*, const Request*) override;

  /// Says NOT_SERVING while the server is not able to keep what it would acknowledge.
  void set_able(bool able) {
    const std::lock_guard lock(mutex_);
    able_ = able;
    tell_all();
  }
  /// Says NOT_SERVING from now on, to all who watch too.
  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    tell_all();
  }

 private:
  class Watcher;
  class RefusedWatch;

  bool knows(const std::string& service) const { return service.empty() || service == service_; }
  /// The functions below require the lock.
  Response::ServingStatus status(bool known) const {
    if (!known) return Response::SERVICE_UNKNOWN;
    return able_ && !stopped_ ? Response::SERVING : Response::NOT_SERVING;
  }
  void tell_all();
  void leave(Watcher* watcher);

  const std::string service_;
  const std::size_t most_;
  std::mutex mutex_;
  bool able_ = true, stopped_ = false;
  std::set<Watcher*> watchers_;
  std::map<std::string, std::size_t> of_connection_;
};

}  // namespace stiefel::server
