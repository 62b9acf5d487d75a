#include "server/calls/cursor_call.h"
#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/diagnosis.h"
#include "server/convert/errors.h"
#include "server/convert/request_price.h"

namespace stiefel::server {
namespace {

/// In bytes.
constexpr std::size_t short_request = std::size_t{64} << 10;

}  // namespace

grpc::ServerUnaryReactor* Service::Diagnose(Context* context, const v1::DiagnoseRequest* request,
                                            v1::DiagnoseResponse* response) {
  CallLog log = open(context, "Diagnose", request->session_id());
  const auto refuse = [&](const grpc::Status& status) { return finished(context, log, status); };
  try {
    auto session = find_session(host_, *context, request->session_id());
    if (!session) return refuse(session.error());
    if (const auto status = check_step("to", request->to()); !status.ok()) return refuse(status);
    MemoryLease memory(log.account().memory(), diagnosis_memory(**session, *request));
    const std::uint64_t held = memory.bytes();
    // A request with many matrices is read on the pool, where a stop can end the reading.
    if (request->ByteSizeLong() > short_request)
      return new CursorCall(
          host_, std::move(log), *std::move(session), request->to(),
          CursorCall::Rest::search(host_, host_.searches.price_cap()),
          [request, response, held](const Session& at, const Cursor& cursor,
                                    const std::stop_token& stop) {
            const auto task = DiagnoseTask::read(at, *request);
            return task ? task->answer(at, cursor, held, stop, response) : task.error();
          },
          std::move(memory));
    auto read = DiagnoseTask::read(**session, *request);
    if (!read) return refuse(read.error());
    const auto task = std::make_shared<const DiagnoseTask>(*std::move(read));
    const double price = task->work(**session);
    const auto rest = task->takes_long(**session) ? CursorCall::Rest::search(host_, price)
                                                  : CursorCall::Rest::of(host_, price);
    return new CursorCall(
        host_, std::move(log), *std::move(session), request->to(), rest,
        [task, response, held](const Session& at, const Cursor& cursor,
                               const std::stop_token& stop) {
          return task->answer(at, cursor, held, stop, response);
        },
        std::move(memory));
  } catch (...) {
    return refuse(errors::from_current_exception());
  }
}

}  // namespace stiefel::server
