#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
void GetSession(ServerCall& call, const v1::GetSessionRequest& request,
                v1::GetSessionResponse* response) {
  const SessionRef session = call.session(request.session_id());
  if (request.view().scene() != v1::SCENE_VIEW_NONE)
    call.hold(memory_price({.reply = scene_reply(*session)}));
  to_proto(*session, session->resolution(), call.host().registry, request.view(),
           response->mutable_session());
}

}  // namespace stiefel::server
