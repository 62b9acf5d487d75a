#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
void GetSession(ServerCall& call, const v1::GetSessionRequest& request,
                v1::GetSessionResponse* response) {
  const SessionRef session = call.session(request.session_id());
  if (request.return_scene()) call.hold(memory_price({.reply = scene_reply(*session)}));
  to_proto(*session, call.host().registry, request.return_scene(), response->mutable_session());
}

}  // namespace stiefel::server
