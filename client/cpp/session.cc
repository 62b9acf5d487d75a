#include "stiefel/client/session.h"

#include "client/cpp/uuid.h"

namespace stiefel::client {

using Stub = v1::SimulationService::Stub;

Session::Session(std::shared_ptr<const Connection> connection, v1::Session description, bool kept)
    : connection_(std::move(connection)), description_(std::move(description)), kept_(kept) {}

Session::~Session() {
  if (!connection_ || kept_) return;
  // One attempt: the server drops an idle session by itself.
  v1::DeleteSessionRequest request;
  request.set_session_id(id());
  v1::DeleteSessionResponse reply;
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + connection_->options.timeout);
  connection_->stub->DeleteSession(&context, request, &reply);
}

v1::Session Session::refresh() const {
  v1::GetSessionRequest request;
  request.set_session_id(id());
  auto reply = connection_->call(&Stub::GetSession, request, connection_->options.timeout);
  return std::move(*reply.mutable_session());
}

v1::StepResponse Session::step(std::int64_t to, const std::vector<std::string>& fields,
                               bool checkpoint) const {
  v1::StepRequest request;
  request.set_session_id(id());
  request.set_to(to);
  request.mutable_fields()->Assign(fields.begin(), fields.end());
  request.set_checkpoint(checkpoint);
  return connection_->call(&Stub::Step, request, connection_->options.compute_timeout);
}

v1::StepResponse Session::step(std::int64_t to, const std::vector<std::string>& fields) const {
  return step(to, fields, false);
}

v1::StepResponse Session::checkpoint(std::int64_t to) const { return step(to, {}, true); }

Drive Session::drive() const { return {connection_, id()}; }

Stream Session::stream(Range range) const { return {connection_, id(), std::move(range)}; }

v1::DiagnoseResponse Session::diagnose(std::int64_t to,
                                       const std::vector<std::string>& invariants) const {
  v1::DiagnoseRequest request;
  request.set_to(to);
  request.mutable_invariants()->Assign(invariants.begin(), invariants.end());
  return diagnose(std::move(request));
}

v1::DiagnoseResponse Session::diagnose(v1::DiagnoseRequest request) const {
  request.set_session_id(id());
  return connection_->call(&Stub::Diagnose, request, connection_->options.compute_timeout);
}

Session Session::fork(v1::ForkSessionRequest request) const {
  request.set_from_session_id(id());
  if (request.session_id().empty()) request.set_session_id(make_uuid());
  auto reply = connection_->call(&Stub::ForkSession, request, connection_->options.compute_timeout);
  if (!reply.has_session())
    throw Error(grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, reply.run_status().message()));
  return Session(connection_, std::move(*reply.mutable_session()), false);
}

}  // namespace stiefel::client
