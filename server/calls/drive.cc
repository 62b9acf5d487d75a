#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/step.h"

namespace stiefel::server {

void Drive(ServerCall& call, ReaderWriter& stream) {
  call.hold(0);  // as many as the largest reply takes
  // The session that the first valid request names, without a reference between requests, so that a
  // silent call does not keep it from expiring.
  std::string id;
  std::weak_ptr<RegisteredSession> known;
  StepTask task;
  const auto session_of = [&](const std::string& named) {
    if (!id.empty() && !named.empty() && named != id)
      throw errors::invalid("session_id", named, "must be empty or '" + id + "'");
    if (auto still = known.lock(); still && !still->closed()) return still->use();
    SessionRef found = call.session(id.empty() ? named : id);
    known = found->weak_from_this();
    id = found->id();
    task.fields = found->default_fields();
    return found;
  };
  const auto answer = [&](const v1::DriveRequest& request, v1::StepResponse* response) {
    if (call.host().lifecycle.refusing()) throw errors::shutting_down();
    const SessionRef session = session_of(request.session_id());
    check_step("to", request.to());
    if (request.fields_size() > 0) task.fields = select_fields(*session, request.fields());
    task.to = request.to();
    task.return_checkpoint = request.return_checkpoint();
    call.memory().grow_to(step_memory(*session, task));
    step(call, *session, task, response);
    response->set_work(call.work());
  };
  grpc::ByteBuffer bytes;
  bool first = true;
  for (; call.next(stream, bytes); first = false) {
    const auto& request = call.read<v1::DriveRequest>(bytes);
    v1::DriveResponse response;
    try {
      call.run([&] { answer(request, response.mutable_step()); });
    } catch (...) {
      const grpc::Status error = call.current_error();
      call.log().refuse(error);
      errors::to_proto(error, response.mutable_error());
    }
    call.drop_request();
    call.write(stream, response);
  }
  if (call.caller_left()) throw errors::cancelled();
  if (first) throw errors::invalid("request", "absent", "the first message must name a session");
}

}  // namespace stiefel::server
