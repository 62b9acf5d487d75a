#include "server/service/step.h"

#include <limits>

#include "server/service/errors.h"
#include "server/service/requests.h"
#include "server/service/service.h"
#include "server/service/walk_call.h"

namespace stiefel::server {

void answer_step(const Session& session, const Walk& walk, const StepTask& task,
                 v1::StepResponse* response) {
  to_proto(walk, session.scene(), response->mutable_ending());
  to_proto(session, walk.simulation(), task.fields, response->mutable_sample());
  response->set_computed_steps(walk.computed_steps());
  if (task.checkpoint) response->set_checkpoint(encode_checkpoint(session, walk.simulation()));
}

bool step_inline(Session& session, const StepTask& task, v1::StepResponse* response) {
  if (session.step_cost() > inline_nanoseconds) return false;
  Walk walk(session, task.to);
  if (walk.nanoseconds_to(task.to) > inline_nanoseconds) return false;
  std::int64_t budget = std::numeric_limits<std::int64_t>::max();
  walk.advance(task.to, budget);
  answer_step(session, walk, task, response);
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
    return new WalkCall(host_, std::move(log), *std::move(session), to,
                        [task = std::move(task), response](const Session& at, const Walk& walk) {
                          answer_step(at, walk, task, response);
                          return grpc::Status::OK;
                        });
  } catch (...) {
    return finish(errors::from_current_exception());
  }
}

}  // namespace stiefel::server
