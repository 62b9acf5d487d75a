#include "stiefel/client/session.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/cpp/uuid.h"

namespace stiefel::client {
namespace {

/// Whether a session's id may be the value of metadata. The server refuses any other id.
bool is_routable(const std::string& id) {
  return !id.empty() && std::ranges::all_of(id, [](char c) { return c > ' ' && c < 0x7F; });
}

}  // namespace

Error Connection::error(const grpc::Status& status) const {
  const bool answered = status.error_code() != grpc::StatusCode::UNAVAILABLE ||
                        !status.error_details().empty() || address.empty();
  if (answered) return Error(status);
  return Error({status.error_code(), "cannot reach " + address + ": " + status.error_message()});
}

Context::Context(const Connection& connection, const std::string& session_id, bool has_timeout)
    : stop_(connection.options.stop, [this] { cancel(); }) {
  if (is_routable(session_id)) context_.AddMetadata("stiefel-session", session_id);
  if (const auto timeout = connection.options.timeout; timeout && has_timeout)
    context_.set_deadline(std::chrono::system_clock::now() + *timeout);
}

Drive::Drive(std::shared_ptr<const Connection> connection, const std::string& session_id)
    : connection_(std::move(connection)),
      context_(std::make_unique<Context>(*connection_, session_id, false)),
      call_(connection_->stub->Drive(context_->get())) {
  request_.set_session_id(session_id);
}

Drive::~Drive() {
  if (!call_) return;
  context_->cancel();
  call_->Finish();
}

v1::StepResponse Drive::step(std::int64_t to, const std::vector<std::string>& fields) {
  if (!call_) throw Error({grpc::StatusCode::FAILED_PRECONDITION, "the drive broke before"});
  request_.set_to(to);
  request_.mutable_fields()->Assign(fields.begin(), fields.end());
  v1::DriveResponse response;
  if (!call_->Write(request_) || !call_->Read(&response)) {
    const grpc::Status status = std::exchange(call_, nullptr)->Finish();
    if (!status.ok()) throw connection_->error(status);
    throw Error({grpc::StatusCode::UNAVAILABLE, "the server ended the drive"});
  }
  if (response.has_error()) throw Error(response.error());
  return std::move(*response.mutable_step());
}

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
  request.set_return_scene(true);
  auto reply = client::call(connection_, &Stub::ForkSession, request);
  if (reply.run_status().outcome() != v1::OUTCOME_REACHED)
    throw Error({grpc::StatusCode::FAILED_PRECONDITION, reply.run_status().message()});
  return Session(connection_, std::move(*reply.mutable_session()));
}

}  // namespace stiefel::client
