#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {
void GetSession(ServerCall& call, const v1::GetSessionRequest& request,
                v1::GetSessionResponse* response) {
  const SessionRef session = call.session(request.session_id());
  if (shows_scenes(request.view())) call.hold(memory_price({.reply = max_reply_bytes}));
  to_proto(*session, session->resolution(), call.host().registry, request.view(),
           response->mutable_session());
}

}  // namespace stiefel::server
