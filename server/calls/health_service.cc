#include "server/calls/health_service.h"

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/convert/errors.h"

namespace stiefel::server {
namespace {

/// How often a Watch looks whether its caller has left.
constexpr std::chrono::milliseconds patience{200};

/// Returns the field `service` of a HealthCheckRequest.
std::string service_of(const grpc::ByteBuffer& request) {
  constexpr char tag = 1 << 3 | 2;
  grpc::Slice bytes;
  if (!request.DumpToSingleSlice(&bytes).ok() || bytes.size() < 2) return {};
  const std::string_view text(reinterpret_cast<const char*>(bytes.begin()), bytes.size());
  return text[0] == tag ? std::string(text.substr(2)) : std::string();
}

/// Returns a HealthCheckResponse.
template <class Status>
grpc::ByteBuffer response_of(Status status) {
  constexpr char tag = 1 << 3;
  const grpc::Slice bytes(std::string{tag, static_cast<char>(status)});
  return {&bytes, 1};
}

}  // namespace

HealthService::HealthService(std::string service) : service_(std::move(service)) {
  using namespace grpc::internal;
  using Bytes = grpc::ByteBuffer;
  AddMethod(
      new RpcServiceMethod("/grpc.health.v1.Health/Check", RpcMethod::NORMAL_RPC,
                           new RpcMethodHandler<HealthService, Bytes, Bytes>(
                               [](HealthService* self, grpc::ServerContext*, const Bytes* request,
                                  Bytes* response) { return self->check(*request, response); },
                               this)));
  AddMethod(new RpcServiceMethod("/grpc.health.v1.Health/Watch", RpcMethod::SERVER_STREAMING,
                                 new ServerStreamingHandler<HealthService, Bytes, Bytes>(
                                     [](HealthService* self, grpc::ServerContext* context,
                                        const Bytes* request, grpc::ServerWriter<Bytes>* writer) {
                                       return self->watch(*context, *request, *writer);
                                     },
                                     this)));
}

grpc::Status HealthService::check(const grpc::ByteBuffer& request, grpc::ByteBuffer* response) {
  if (!knows(service_of(request))) return {grpc::NOT_FOUND, "there is no such service"};
  const std::lock_guard lock(mutex_);
  *response = response_of(status(true));
  return grpc::Status::OK;
}

grpc::Status HealthService::watch(grpc::ServerContext& context, const grpc::ByteBuffer& request,
                                  grpc::ServerWriter<grpc::ByteBuffer>& writer) {
  std::unique_lock lock(mutex_);
  if (watches_ >= most) {
    constexpr auto limit = static_cast<double>(most);
    return errors::over_quota({"health_watches", limit, limit + 1, std::chrono::seconds(1)});
  }
  ++watches_;
  tell(context, knows(service_of(request)), writer, lock);
  --watches_;
  return errors::cancelled();
}

void HealthService::tell(grpc::ServerContext& context, bool known,
                         grpc::ServerWriter<grpc::ByteBuffer>& writer,
                         std::unique_lock<std::mutex>& lock) {
  for (std::optional<Status> told; !context.IsCancelled();) {
    const Status now = status(known);
    if (told == now) {
      changed_.wait_for(lock, patience);
      continue;
    }
    lock.unlock();
    const bool sent = writer.Write(response_of(now));
    lock.lock();
    if (!sent) return;
    told = now;
  }
}

}  // namespace stiefel::server
