#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
void CreateSession(ServerCall& call, const v1::CreateSessionRequest& request,
                   v1::CreateSessionResponse* response) {
  Host& host = call.host();
  MemoryBudget& memory = call.account().memory();
  if (host.lifecycle.refusing()) throw errors::shutting_down();
  check_session_id(request.session_id());
  check_routing(call.context(), request.session_id());
  call.hold(memory_price({.request = held_by(request)}));
  const v1::Scene& given = request.scene();
  MemoryLease resolving(memory, scene_workspace(given));
  ResolvedScene scene = read_scene(request.has_scene(), given, "scene", [&](std::uint64_t bytes) {
    resolving.grow_to(resolving.bytes() + bytes);
  });
  resolving = {};  // the session pays for its scene
  // A session is made only if its first step and the reply fit beside it. The state may have twice
  // the arrays of the request.
  const MemoryLease step(memory, memory_price({.workspace = first_step_workspace(scene.scene),
                                               .reply = 2 * held_by(given)}));
  const auto made = admit(host, call.account(), request.session_id(), std::move(scene),
                          request.checkpoint(), request.recreate());
  to_proto(*made.session, host.registry, request.return_scene(), response->mutable_session());
  response->set_created(made.created);
  call.hold(memory_price({.reply = response->ByteSizeLong()}));
  call.wait_for(made.pending_write);
}

}  // namespace stiefel::server
