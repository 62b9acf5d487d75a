#include "server/admission/principal.h"

#include "server/connections/callers.h"

namespace stiefel::server {

Principal principal_of(const grpc::CallbackServerContext& context) {
  const auto* caller = dynamic_cast<const CallerContext*>(&context);
  return caller == nullptr ? Principal{} : caller->principal();
}

}  // namespace stiefel::server
