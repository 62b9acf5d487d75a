#include "server/calls/step.h"

#include <limits>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/unary_call.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {
namespace {

/// The most members of an ensemble whose steps run on the thread that received the call.
constexpr std::size_t inline_members = 4;

std::size_t reply_bytes(const Session& session, const StepTask& task) {
  return sample_bytes(session, task.fields) +
         (task.return_checkpoint ? checkpoint_bytes(session) : 0);
}

}  // namespace

std::uint64_t step_memory(const Session& session, const StepTask& task) {
  return memory_price({.reply = reply_bytes(session, task)});
}

grpc::Status check_size(const Session& session, const StepTask& task) {
  const std::size_t bytes = reply_bytes(session, task);
  return bytes <= max_reply_bytes ? grpc::Status::OK : errors::reply_too_large(bytes);
}

void answer_step(const Session& session, const Cursor& cursor, const StepTask& task,
                 v1::StepResponse* response) {
  to_proto(cursor, session.scene(), response->mutable_run_status());
  to_proto(session, cursor.simulation(), task.fields, response->mutable_sample());
  demand_finite(is_finite(response->sample().fields()), response->mutable_run_status());
  response->set_computed_steps(cursor.computed_steps());
  to_proto(session.most_work(cursor.start(), task.to), reply_bytes(session, task),
           bound_of_steps(session), session.simulation_bytes() + step_memory(session, task),
           response->mutable_price());
  if (task.return_checkpoint)
    response->set_checkpoint(encode_checkpoint(session, cursor.simulation()));
}

bool step_inline(Session& session, const StepTask& task, Account& account,
                 v1::StepResponse* response) {
  if (session.step_kind().unpredictable || session.step_cost() > inline_nanoseconds) return false;
  // The simulation of an ensemble may have to be made first, which takes 10 µs a member.
  if (session.scene().members().size() > inline_members) return false;
  Cursor cursor(session, task.to);
  if (cursor.nanoseconds_to(task.to) > inline_nanoseconds) return false;
  std::int64_t budget = std::numeric_limits<std::int64_t>::max();
  cursor.advance(task.to, budget);
  account.pay(session.work(cursor.start(), task.to));
  answer_step(session, cursor, task, response);
  return true;
}

Service::Unary Service::Step(Context& context, CallLog& log, const v1::StepRequest& request,
                             v1::StepResponse* response) {
  auto session = find_session(host_, context, request.session_id());
  if (!session) return session.error();
  if (auto status = check_step("to", request.to()); !status.ok()) return status;
  auto fields = select_fields(**session, request.fields());
  if (!fields) return errors::invalid(fields.error());
  StepTask task{request.to(), *std::move(fields), request.return_checkpoint()};
  if (auto status = check_size(**session, task); !status.ok()) return status;
  if (step_inline(**session, task, log.account(), response)) {
    log.did(response->price().work(), response->computed_steps());
    return grpc::Status::OK;
  }
  MemoryLease memory(log.account().memory(), step_memory(**session, task));
  return new UnaryCall(
      host_, std::move(log), *std::move(session), request.to(), {},
      [task = std::move(task), response](const Session& at, const Cursor& cursor,
                                         const std::stop_token&) {
        answer_step(at, cursor, task, response);
        return grpc::Status::OK;
      },
      std::move(memory));
}

}  // namespace stiefel::server
