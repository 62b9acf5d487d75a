#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/unary_call.h"
#include "server/convert/diagnose_task.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
namespace {

/// In bytes.
constexpr std::size_t short_request = std::size_t{64} << 10;

}  // namespace

Service::Unary Service::Diagnose(Context& context, CallLog& log, const v1::DiagnoseRequest& request,
                                 v1::DiagnoseResponse* response) {
  auto session = find_session(host_, context, request.session_id());
  if (!session) return session.error();
  if (auto status = check_step("to", request.to()); !status.ok()) return status;
  const std::uint64_t held = memory_price({held_by(request), diagnosis_workspace(**session)});
  const auto call = [&](const UnaryCall::MoreWork& more, UnaryCall::Answer answer) {
    MemoryLease memory(log.account().memory(), held);
    return new UnaryCall(host_, std::move(log), *std::move(session), request.to(), more,
                         std::move(answer), std::move(memory));
  };
  // A request with many matrices is read by a worker, where a stop can end the reading.
  if (request.ByteSizeLong() > short_request)
    return call({price_cap(JobKind::unsliced), JobKind::unsliced},
                [&request, response, held](const Session& at, const Cursor& cursor,
                                           const std::stop_token& stop) {
                  const auto task = DiagnoseTask::read(at, request);
                  return task ? task->answer(at, cursor, held, stop, response) : task.error();
                });
  auto read = DiagnoseTask::read(**session, request);
  if (!read) return read.error();
  const auto task = std::make_shared<const DiagnoseTask>(*std::move(read));
  const double price = task->work(**session);
  return call(
      task->takes_long(**session) ? UnaryCall::MoreWork{price, JobKind::unsliced}
                                  : UnaryCall::MoreWork::of(price),
      [task, response, held](const Session& at, const Cursor& cursor, const std::stop_token& stop) {
        return task->answer(at, cursor, held, stop, response);
      });
}

}  // namespace stiefel::server
