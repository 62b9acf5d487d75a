#pragma once

#include <grpcpp/server_context.h>

#include "server/sessions/principal.h"

namespace stiefel::server {

/// The caller of a call.
Principal principal_of(const grpc::CallbackServerContext& context);

}  // namespace stiefel::server
