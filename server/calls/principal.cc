#include "server/calls/principal.h"

namespace stiefel::server {

Principal principal_of(const grpc::CallbackServerContext&) { return {}; }

}  // namespace stiefel::server
