#include "server/observability/push_back.h"

#include <string>

#include "server/convert/errors.h"

namespace stiefel::server {

void push_back(const grpc::Status& status, grpc::CallbackServerContext& context) {
  if (status.error_code() != grpc::RESOURCE_EXHAUSTED) return;
  const auto delay = errors::retry_delay(status);
  context.AddTrailingMetadata("grpc-retry-pushback-ms",
                              delay ? std::to_string(delay->count()) : "-1");
}

}  // namespace stiefel::server
