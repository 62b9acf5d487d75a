#include "stiefel/client/drive.h"

#include <utility>

namespace stiefel::client {

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

}  // namespace stiefel::client
