#include "stiefel/client/drive.h"

#include <utility>

#include "client/cpp/replies.h"
#include "client/cpp/step_by_stream.h"

namespace stiefel::client {

Drive::Drive(std::shared_ptr<const Connection> connection, std::string session_id,
             std::shared_ptr<Recreation> recreation)
    : connection_(std::move(connection)),
      recreation_(recreation ? std::move(recreation)
                             : std::make_shared<Recreation>(connection_, session_id)) {
  request_.set_session_id(std::move(session_id));
  open();
}

Drive::~Drive() { close(); }

void Drive::open() {
  cancel_.reset();
  context_ = std::make_unique<grpc::ClientContext>();
  cancel_ = std::make_unique<CancelOnStop>(connection_->options.stop, *context_);
  recreation_->route(*context_);
  call_ = connection_->stub->Drive(context_.get());
}

void Drive::close() {
  if (!call_) return;
  context_->TryCancel();
  call_->Finish();
  call_.reset();
}

v1::StepResponse Drive::step(std::int64_t to, const std::vector<std::string>& fields) {
  recreation_->check_not_deleted();
  if (!call_) open();  // the previous step has failed
  const auto in_force = request_.fields();
  request_.set_to(to);
  if (!fields.empty()) request_.mutable_fields()->Assign(fields.begin(), fields.end());
  request_.set_return_checkpoint(recreation_->wants_checkpoint(to));
  const Deadline none(std::nullopt);
  for (auto pauses = connection_->patience(none),
            recoveries = connection_->patience_to_recover(none);
       ;) {
    v1::DriveResponse response;
    if (const grpc::Status status = ask(response); !status.ok()) {
      if (!pauses.allows_another(status) &&
          !recreation_->recovers(connection_->error(status), none, recoveries))
        throw connection_->error(status);
      open();
      continue;
    }
    if (response.has_step()) {
      check_step(response.step(), to, request_.fields(), request_.return_checkpoint());
      recreation_->take(*response.mutable_step(), false);
      return std::move(*response.mutable_step());
    }
    check_present(response, {"error"});
    const v1::Status& refusal = response.error();
    if (refusal.code() == grpc::StatusCode::RESOURCE_EXHAUSTED &&
        pauses.allows_another(
            {grpc::StatusCode::RESOURCE_EXHAUSTED, refusal.message(), refusal.SerializeAsString()}))
      continue;
    const Error error(refusal);
    if (is_too_large(error)) {
      v1::StepRequest request;
      request.set_session_id(request_.session_id());
      request.set_to(to);
      *request.mutable_fields() = request_.fields();
      return step_by_stream(connection_, request, recreation_);
    }
    if (!recreation_->recovers(error, none, recoveries)) {
      *request_.mutable_fields() = in_force;
      throw error;
    }
    close();  // the session may be at another server now
    open();
  }
}

grpc::Status Drive::ask(v1::DriveResponse& response) {
  if (call_->Write(request_) && call_->Read(&response)) {
    recreation_->check_build(*context_, false);
    return grpc::Status::OK;
  }
  // A reply that cannot be parsed does not end the call: without this, Finish would not return.
  call_->WritesDone();
  const grpc::Status status = call_->Finish();
  call_.reset();
  if (!status.ok()) return status;
  return {grpc::StatusCode::UNAVAILABLE, "the server ended the drive"};
}

}  // namespace stiefel::client
