#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

namespace stiefel::server {

/// Tells gRPC's own retries of a refusal when to come back, in the trailing metadata
/// `grpc-retry-pushback-ms`: after the delay of the status, or, without one, never (-1). Only of
/// RESOURCE_EXHAUSTED, and before the call is finished.
void push_back(const grpc::Status& status, grpc::CallbackServerContext& context);

}  // namespace stiefel::server
