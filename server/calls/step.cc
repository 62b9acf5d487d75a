#include "server/calls/step.h"

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {

std::uint64_t step_memory(const Session& session, const StepTask& task) {
  const std::size_t checkpoint = task.return_checkpoint ? checkpoint_bytes(session) : 0;
  return memory_price({.reply = sample_bytes(session, task.fields) + checkpoint});
}

void step(ServerCall& call, Session& session, const StepTask& task, v1::StepResponse* response) {
  Cursor cursor(session, task.to);
  call.advance(session, cursor, task.to);
  to_proto(cursor, session.scene(), response->mutable_run_status());
  to_proto(session, cursor.simulation(), task.fields, response->mutable_sample());
  demand_finite(is_finite(response->sample().fields()), response->mutable_run_status());
  response->set_computed_steps(cursor.computed_steps());
  if (task.return_checkpoint)
    response->set_checkpoint(encode_checkpoint(session, cursor.simulation()));
}

void Step(ServerCall& call, const v1::StepRequest& request, v1::StepResponse* response) {
  const SessionRef session = call.session(request.session_id());
  check_step("to", request.to());
  const StepTask task{request.to(), select_fields(*session, request.fields()),
                      request.return_checkpoint()};
  call.hold(step_memory(*session, task));
  step(call, *session, task, response);
}

}  // namespace stiefel::server
