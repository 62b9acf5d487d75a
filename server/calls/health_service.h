#pragma once

#include <google/protobuf/wrappers.pb.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/impl/service_type.h>
#include <grpcpp/support/sync_stream.h>

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>

namespace stiefel::server {

/// The standard health service, which needs no token. Unlike gRPC's own it limits the open Watches,
/// each of which has a thread: further ones end with RESOURCE_EXHAUSTED. Thread-safe.
///
/// gRPC's own, as every service of the callback API, would give the server threads that poll its
/// connections for a second and then sleep for 0.1 s (gRPC 1.51, CallbackAlternativeCQ), while no
/// call begins.
class HealthService final : public grpc::Service {
 public:
  /// The most Watches at once.
  static constexpr std::size_t most = 64;

  /// `service`: the full name of the service that is healthy beside the server itself.
  explicit HealthService(std::string service);

  /// Says NOT_SERVING while the server is not able to keep what it would acknowledge.
  void set_able(bool able) {
    const std::lock_guard lock(mutex_);
    able_ = able;
    changed_.notify_all();
  }
  /// Says NOT_SERVING from now on, to all who watch too.
  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }

 private:
  // grpc.health.v1.HealthCheckRequest and HealthCheckResponse, whose only fields have number 1.
  using Request = google::protobuf::StringValue;
  using Response = google::protobuf::Int32Value;
  /// The values of grpc.health.v1.HealthCheckResponse.ServingStatus.
  enum class Status { serving = 1, not_serving = 2, service_unknown = 3 };

  grpc::Status check(grpc::ServerContext* context, const Request* request, Response* response);
  /// Tells a caller the status, and again at every change, until the caller leaves.
  grpc::Status watch(grpc::ServerContext* context, const Request* request,
                     grpc::ServerWriter<Response>* writer);
  bool knows(const std::string& service) const { return service.empty() || service == service_; }
  /// Requires the lock.
  Status status(bool known) const {
    if (!known) return Status::service_unknown;
    return able_ && !stopped_ ? Status::serving : Status::not_serving;
  }
  const std::string service_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool able_ = true, stopped_ = false;
  std::size_t watches_ = 0;
};

}  // namespace stiefel::server
