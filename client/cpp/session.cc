#include "stiefel/client/session.h"

#include <utility>

#include "client/cpp/uuid.h"

namespace stiefel::client {

v1::StepResponse Session::step(std::int64_t to, const std::vector<std::string>& fields) const {
  v1::StepRequest request;
  request.set_to(to);
  request.mutable_fields()->Assign(fields.begin(), fields.end());
  return call(&Stub::Step, std::move(request));
}

Samples Session::stream(const Range& range) const {
  v1::StreamRequest request;
  request.set_from(range.from);
  request.set_to(range.to);
  request.set_every(range.every);
  request.mutable_fields()->Assign(range.fields.begin(), range.fields.end());
  return stream(std::move(request));
}

Samples Session::stream(v1::StreamRequest request) const {
  return Samples(call(&Stub::Stream, std::move(request)));
}

Session Session::fork(v1::ForkSessionRequest request) const {
  request.set_from_session_id(id());
  if (request.session_id().empty()) request.set_session_id(make_uuid());
  request.mutable_view()->set_scene(v1::SCENE_VIEW_FULL);
  auto reply = client::call(connection_, &Stub::ForkSession, request);
  if (reply.run_status().outcome() != v1::OUTCOME_REACHED)
    throw Error({grpc::StatusCode::FAILED_PRECONDITION, reply.run_status().message()});
  return Session(connection_, std::move(*reply.mutable_session()));
}

}  // namespace stiefel::client
