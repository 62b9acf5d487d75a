#include "server/calls/requests.h"
#include "server/calls/service.h"

namespace stiefel::server {
void DeleteSession(ServerCall& call, const v1::DeleteSessionRequest& request,
                   v1::DeleteSessionResponse*) {
  check_session_id(request.session_id());
  check_routing(call.context(), request.session_id());
  MemoryBudget& memory = call.account().memory();
  call.wait_for(call.host().registry.erase(call.principal(), request.session_id(), &memory));
}

}  // namespace stiefel::server
