#include "server/calls/step.h"

#include <limits>

#include "server/calls/cursor_call.h"
#include "server/calls/service.h"
#include "server/convert/errors.h"
#include "server/convert/requests.h"

namespace stiefel::server {

void answer_step(const Session& session, const Cursor& cursor, const StepTask& task,
                 v1::StepResponse* response) {
  to_proto(cursor, session.scene(), response->mutable_run_status());
  to_proto(session, cursor.simulation(), task.fields, response->mutable_sample());
  response->set_computed_steps(cursor.computed_steps());
  if (task.checkpoint) response->set_checkpoint(encode_checkpoint(session, cursor.simulation()));
}

bool step_inline(Session& session, const StepTask& task, v1::StepResponse* response) {
  if (session.step_cost() > inline_nanoseconds) return false;
  Cursor cursor(session, task.to);
  if (cursor.nanoseconds_to(task.to) > inline_nanoseconds) return false;
  std::int64_t budget = std::numeric_limits<std::int64_t>::max();
  cursor.advance(task.to, budget);
  answer_step(session, cursor, task, response);
  return true;
}

grpc::ServerUnaryReactor* Service::Step(grpc::CallbackServerContext* context,
                                        const v1::StepRequest* request,
                                        v1::StepResponse* response) {
  CallLog log(host_.log, *context, "Step", request->session_id());
  const auto finish = [&](const grpc::Status& status) {
    log.finish(status, response->computed_steps());
    auto* reactor = context->DefaultReactor();
    reactor->Finish(status);
    return reactor;
  };
  try {
    auto session = find_session(host_, request->session_id());
    if (!session) return finish(session.error());
    if (const auto status = check_step("to", request->to()); !status.ok()) return finish(status);
    auto fields = select_fields(**session, request->fields());
    if (!fields) return finish(errors::invalid(fields.error()));

    StepTask task{request->to(), *std::move(fields), request->checkpoint()};
    if (step_inline(**session, task, response)) return finish(grpc::Status::OK);
    const std::int64_t to = task.to;
    return new CursorCall(
        host_, std::move(log), *std::move(session), to,
        [task = std::move(task), response](const Session& at, const Cursor& cursor) {
          answer_step(at, cursor, task, response);
          return grpc::Status::OK;
        });
  } catch (...) {
    return finish(errors::from_current_exception());
  }
}

}  // namespace stiefel::server
