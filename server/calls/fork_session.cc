#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
void ForkSession(ServerCall& call, const v1::ForkSessionRequest& request,
                 v1::ForkSessionResponse* response) {
  const SessionRef from = call.session(request.from_session_id(), "from_session_id");
  check_session_id(request.session_id());
  check_step("from_step", request.from_step());
  // The scene in its steps from the old one to the new one.
  call.hold(memory_price({.workspace = 2 * from->scene_bytes(), .reply = scene_reply(*from)}));
  Cursor cursor(*from, request.from_step());
  call.advance(*from, cursor, request.from_step());
  to_proto(cursor, from->scene(), response->mutable_run_status());
  if (!cursor.run_status().reached()) return;
  const auto made =
      admit(call.host(), call.account(), request.session_id(), forked(*from, cursor, request));
  to_proto(*made.session, call.host().registry, request.return_scene(),
           response->mutable_session());
  response->set_created(made.created);
  call.wait_for(made.pending_write);
}

}  // namespace stiefel::server
