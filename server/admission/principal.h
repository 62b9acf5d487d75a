#pragma once

#include <grpcpp/server_context.h>

#include "server/scheduling/principal.h"

namespace stiefel::server {

/// Returns the caller of a call that the gate let in (gate.h); the principal "" at a server without
/// tokens.
Principal principal_of(const grpc::CallbackServerContext& context);

}  // namespace stiefel::server
