#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

namespace stiefel::server {

/// Tells gRPC's retries of a refused call when to come back, in the trailing metadata
/// `grpc-retry-pushback-ms`: after the delay of the status, or never (-1) if it has none. Acts on
/// RESOURCE_EXHAUSTED only. Call it before the call is finished.
void push_back(const grpc::Status& status, grpc::CallbackServerContext& context);

}  // namespace stiefel::server
