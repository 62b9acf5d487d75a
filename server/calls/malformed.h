#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <memory>
#include <vector>

#include "server/calls/log.h"

namespace stiefel::server {

/// Requests that are no messages of their type never reach a handler: gRPC ends such a call with
/// UNIMPLEMENTED and no text. What this makes turns that into INVALID_ARGUMENT with a reason, and
/// logs a line of level warning. The log must outlive the server.
std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
report_malformed(const Log& log);

}  // namespace stiefel::server
