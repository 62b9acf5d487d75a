#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/diagnose_task.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
void Diagnose(ServerCall& call, const v1::DiagnoseRequest& request,
              v1::DiagnoseResponse* response) {
  const SessionRef session = call.session(request.session_id());
  check_step("to", request.to());
  call.hold(memory_price({held_by(request), diagnosis_workspace(*session)}));
  const DiagnoseTask task = read(*session, request);
  Cursor cursor(*session, request.to());
  call.advance(*session, cursor, request.to());
  answer(task, *session, cursor, call.stop(), response);
  call.pass();  // an answer computed during a stop may be incomplete
}

}  // namespace stiefel::server
