#include "server/calls/step.h"

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {
namespace {

std::size_t reply_bytes(const Session& session, const StepTask& task) {
  return sample_bytes(session, task.fields) +
         (task.return_checkpoint ? checkpoint_bytes(session) : 0);
}

/// Writes the reply at the step where the cursor ended.
void answer_step(const Session& session, const Cursor& cursor, const StepTask& task,
                 v1::StepResponse* response) {
  to_proto(cursor, session.scene(), response->mutable_run_status());
  to_proto(session, cursor.simulation(), task.fields, response->mutable_sample());
  demand_finite(is_finite(response->sample().fields()), response->mutable_run_status());
  response->set_computed_steps(cursor.computed_steps());
  if (task.return_checkpoint)
    response->set_checkpoint(encode_checkpoint(session, cursor.simulation()));
}

}  // namespace

std::uint64_t step_memory(const Session& session, const StepTask& task) {
  return memory_price({.reply = reply_bytes(session, task)});
}

void advance(ServerCall& call, const Session& session, Cursor& cursor, std::int64_t to) {
  const auto piece = [&] {
    std::int64_t steps = slice_steps(session.step_cost());
    return cursor.advance(to, steps, call.stop());
  };
  try {
    while (!piece()) call.pass();
  } catch (const Stopped&) {
    cursor.cancel();
  }
  call.log().did(0, cursor.computed_steps());
  if (!cursor.stopped()) return;
  if (!call.host().lifecycle.stopping()) throw Stopped();
  throw errors::shutting_down(session, cursor.simulation());
}

void step(ServerCall& call, Session& session, const StepTask& task, v1::StepResponse* response) {
  Cursor cursor(session, task.to);
  advance(call, session, cursor, task.to);
  answer_step(session, cursor, task, response);
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
