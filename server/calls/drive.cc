#include <memory>
#include <string>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/step.h"
#include "server/convert/errors.h"

namespace stiefel::server {
namespace {

/// The session that the first valid request names, without a reference between requests, so that a
/// silent call does not keep it from expiring.
class Driven {
 public:
  /// Checks the request and answers it.
  void answer(ServerCall& call, const v1::DriveRequest& request, v1::StepResponse* response) {
    if (call.host().lifecycle.refusing()) throw errors::shutting_down();
    const SessionRef session = find(call, request.session_id());
    check_step("to", request.to());
    if (request.fields_size() > 0) task_.fields = select_fields(*session, request.fields());
    task_.to = request.to();
    task_.return_checkpoint = request.return_checkpoint();
    call.memory().grow_to(step_memory(*session, task_));
    step(call, *session, task_, response);
  }

 private:
  SessionRef find(ServerCall& call, const std::string& id) {
    if (!id_.empty() && !id.empty() && id != id_)
      throw errors::invalid("session_id", id, "must be empty or '" + id_ + "'");
    if (auto known = known_.lock(); known && !known->closed()) return known->use();
    SessionRef session = call.session(id_.empty() ? id : id_);
    known_ = session->weak_from_this();
    id_ = session->id();
    task_.fields = session->default_fields();
    return session;
  }

  std::string id_;
  std::weak_ptr<RegisteredSession> known_;
  StepTask task_;
};

}  // namespace

void Drive(ServerCall& call,
           grpc::ServerReaderWriter<v1::DriveResponse, grpc::ByteBuffer>& stream) {
  call.hold(0);  // as many as the largest reply takes
  Driven driven;
  grpc::ByteBuffer bytes;
  v1::DriveResponse response;
  bool first = true;
  for (; call.next(stream, bytes); first = false) {
    const auto& request = call.read<v1::DriveRequest>(bytes);
    response.has_step() ? response.mutable_step()->Clear() : response.Clear();
    try {
      call.run([&] {
        driven.answer(call, request, response.mutable_step());
        response.mutable_step()->set_work(call.work());
      });
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
