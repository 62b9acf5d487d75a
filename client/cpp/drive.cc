#include "stiefel/client/drive.h"

#include "client/cpp/step_by_stream.h"
#include "client/cpp/verify.h"

namespace stiefel::client {

Drive::Drive(std::shared_ptr<const Connection> connection, std::string session_id)
    : connection_(std::move(connection)),
      context_(std::make_unique<grpc::ClientContext>()),
      cancel_(std::make_unique<CancelOnStop>(connection_->options.stop, *context_)) {
  request_.set_session_id(std::move(session_id));
  request_.set_checksum(connection_->options.checksums);
  call_ = connection_->stub->Drive(context_.get());
}

Drive::~Drive() {
  if (!call_) return;
  context_->TryCancel();
  call_->Finish();
}

v1::StepResponse Drive::step(std::int64_t to, const std::vector<std::string>& fields) {
  if (!call_) throw Error(grpc::StatusCode::FAILED_PRECONDITION, "the drive has ended");
  const auto in_force = request_.fields();
  request_.set_to(to);
  if (!fields.empty()) request_.mutable_fields()->Assign(fields.begin(), fields.end());
  v1::DriveResponse response;
  for (auto patience = connection_->patience(Deadline(std::nullopt));;) {
    if (!call_->Write(request_)) fail();
    if (!call_->Read(&response)) fail();
    if (response.error().code() != grpc::StatusCode::RESOURCE_EXHAUSTED) break;
    const v1::Status& refusal = response.error();
    if (!patience.allows_another(
            {grpc::StatusCode::RESOURCE_EXHAUSTED, refusal.message(), refusal.SerializeAsString()}))
      break;
  }
  if (response.has_step()) {
    verify(response.step().sample(), "the state at step " + std::to_string(to));
    return std::move(*response.mutable_step());
  }
  const Error error(response.error());
  if (is_too_large(error)) {
    v1::StepRequest request;
    request.set_session_id(request_.session_id());
    request.set_to(to);
    *request.mutable_fields() = request_.fields();
    return step_by_stream(connection_, request);
  }
  *request_.mutable_fields() = in_force;
  throw error;
}

void Drive::fail() {
  const grpc::Status status = call_->Finish();
  call_.reset();
  if (status.ok()) throw Error(grpc::StatusCode::UNAVAILABLE, "the server ended the drive");
  throw connection_->error(status);
}

}  // namespace stiefel::client
