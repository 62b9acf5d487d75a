#include "server/calls/health_service.h"

#include <chrono>

#include "server/convert/errors.h"

namespace stiefel::server {
namespace {

/// How often a Watch looks whether its caller has left.
constexpr std::chrono::milliseconds patience{200};

grpc::Status too_many(std::size_t most) {
  const auto limit = static_cast<double>(most);
  return errors::over_quota({"health_watches", limit, limit + 1, std::chrono::seconds(1)});
}

}  // namespace

grpc::Status HealthService::Check(grpc::ServerContext*, const Request* request,
                                  Response* response) {
  if (!knows(request->service())) return {grpc::NOT_FOUND, "there is no such service"};
  const std::lock_guard lock(mutex_);
  response->set_status(status(true));
  return grpc::Status::OK;
}

grpc::Status HealthService::Watch(grpc::ServerContext* context, const Request* request,
                                  grpc::ServerWriter<Response>* writer) {
  const std::string connection = context->peer();
  {
    const std::lock_guard lock(mutex_);
    if (watches_ >= most) return too_many(most);
    if (of_connection_[connection] >= most_of_connection) return too_many(most_of_connection);
    ++watches_;
    ++of_connection_[connection];
  }
  tell(*context, knows(request->service()), *writer);
  const std::lock_guard lock(mutex_);
  --watches_;
  if (--of_connection_[connection] == 0) of_connection_.erase(connection);
  return errors::cancelled();
}

void HealthService::tell(grpc::ServerContext& context, bool known,
                         grpc::ServerWriter<Response>& writer) {
  Response response;
  for (bool told = false; !context.IsCancelled();) {
    std::unique_lock lock(mutex_);
    const auto now = status(known);
    if (told && now == response.status()) {
      changed_.wait_for(lock, patience);
      continue;
    }
    lock.unlock();
    response.set_status(now);
    if (!writer.Write(response)) return;
    told = true;
  }
}

}  // namespace stiefel::server
