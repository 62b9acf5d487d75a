#include "stiefel/client/drive.h"

namespace stiefel::client {

Drive::Drive(std::shared_ptr<const Connection> connection, std::string session_id)
    : connection_(std::move(connection)),
      context_(std::make_unique<grpc::ClientContext>()),
      cancel_(std::make_unique<CancelOnStop>(connection_->options.stop, *context_)) {
  request_.set_session_id(std::move(session_id));
  call_ = connection_->stub->Drive(context_.get());
}

Drive::~Drive() {
  if (!call_) return;
  context_->TryCancel();
  call_->Finish();
}

v1::StepResponse Drive::step(std::int64_t to, const std::vector<std::string>& fields) {
  if (!call_) throw Error(grpc::StatusCode::FAILED_PRECONDITION, "the drive has ended", "");
  request_.set_to(to);
  request_.mutable_fields()->Assign(fields.begin(), fields.end());
  if (!call_->Write(request_)) fail();
  v1::DriveResponse response;
  if (!call_->Read(&response)) fail();
  if (response.has_error()) {
    const auto& error = response.error();
    throw Error(static_cast<grpc::StatusCode>(error.code()), error.message(), error.details());
  }
  return std::move(*response.mutable_step());
}

void Drive::fail() {
  const grpc::Status status = call_->Finish();
  call_.reset();
  if (status.ok()) throw Error(grpc::StatusCode::UNAVAILABLE, "the server ended the drive", "");
  throw connection_->error(status);
}

}  // namespace stiefel::client
