#include "server/calls/health_service.h"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/method_handler.h>

#include <chrono>
#include <optional>
#include <utility>

#include "server/convert/errors.h"

namespace stiefel::server {
namespace {

/// How often a Watch looks whether its caller has left.
constexpr std::chrono::milliseconds patience{200};

template <class Status>
google::protobuf::Int32Value response_of(Status status) {
  google::protobuf::Int32Value response;
  response.set_value(static_cast<int>(status));
  return response;
}

}  // namespace

HealthService::HealthService(std::string service) : service_(std::move(service)) {
  using namespace grpc::internal;
  const auto add = [this](const char* path, RpcMethod::RpcType type, MethodHandler* handler) {
    AddMethod(new RpcServiceMethod(path, type, handler));
  };
  add("/grpc.health.v1.Health/Check", RpcMethod::NORMAL_RPC,
      new RpcMethodHandler<HealthService, Request, Response>(std::mem_fn(&HealthService::check),
                                                             this));
  add("/grpc.health.v1.Health/Watch", RpcMethod::SERVER_STREAMING,
      new ServerStreamingHandler<HealthService, Request, Response>(
          std::mem_fn(&HealthService::watch), this));
}

grpc::Status HealthService::check(grpc::ServerContext*, const Request* request,
                                  Response* response) {
  if (!knows(request->value())) return {grpc::NOT_FOUND, "there is no such service"};
  const std::lock_guard lock(mutex_);
  *response = response_of(status(true));
  return grpc::Status::OK;
}

grpc::Status HealthService::watch(grpc::ServerContext* context, const Request* request,
                                  grpc::ServerWriter<Response>* writer) {
  const bool known = knows(request->value());
  std::unique_lock lock(mutex_);
  if (watches_ >= most) {
    constexpr auto limit = static_cast<double>(most);
    return errors::over_quota({"health_watches", limit, limit + 1, std::chrono::seconds(1)});
  }
  ++watches_;
  std::optional<Status> told;
  for (bool there = true; there && !context->IsCancelled();) {
    const Status now = status(known);
    if (told == now) {
      changed_.wait_for(lock, patience);
      continue;
    }
    lock.unlock();
    there = writer->Write(response_of(now));
    lock.lock();
    told = now;
  }
  --watches_;
  return errors::cancelled();
}

}  // namespace stiefel::server
