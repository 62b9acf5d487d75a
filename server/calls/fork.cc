#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/unary_call.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/convert/resolve.h"
#include "server/convert/work_price.h"

namespace stiefel::server {
namespace {

Answered fork(Host& host, Account& account, std::uint64_t held, const Session& from,
              const Cursor& cursor, const v1::ForkSessionRequest& request,
              v1::ForkSessionResponse* response) {
  to_proto(cursor, from.scene(), response->mutable_run_status());
  to_proto(from.most_work(cursor.start(), request.from_step()), 0, bound_of_steps(from),
           from.simulation_bytes() + held, response->mutable_price());
  if (!cursor.run_status().reached()) return grpc::Status::OK;
  auto scene = forked(from, cursor, request);
  if (!scene) return scene.error();
  const Resolution resolution = scene->resolution;
  const auto made = admit(host, account, request.session_id(), *std::move(scene));
  if (!made) return made.error();
  to_proto(*made->session, resolution, host.registry, request.view(), response->mutable_session());
  response->set_created(made->created);
  return {grpc::Status::OK, made->pending_write};
}

}  // namespace

Service::Unary Service::ForkSession(Context& context, CallLog& log,
                                    const v1::ForkSessionRequest& request,
                                    v1::ForkSessionResponse* response) {
  auto from = find_session(host_, context, request.from_session_id(), "from_session_id");
  if (!from) return from.error();
  if (auto status = check_session_id(request.session_id()); !status.ok()) return status;
  if (auto status = check_step("from_step", request.from_step()); !status.ok()) return status;
  // The scene in its steps from the old one to the new one.
  MemoryLease memory(log.account().memory(),
                     memory_price({.workspace = 2 * (*from)->scene_bytes()}));
  const double price = fork_work(**from, request);
  Account& account = log.account();
  return new UnaryCall(
      host_, std::move(log), *std::move(from), request.from_step(), UnaryCall::MoreWork::of(price),
      [&host = host_, &account, held = memory.bytes(), &request, response](
          const Session& at, const Cursor& cursor, const std::stop_token&) {
        return fork(host, account, held, at, cursor, request, response);
      },
      std::move(memory));
}

}  // namespace stiefel::server
