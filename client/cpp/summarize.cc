#include "client/cpp/assembly.h"
#include "client/cpp/verify.h"
#include "stiefel/client/session.h"

namespace stiefel::client {
namespace {

/// Reads one stream of a Summarize: passes whole events and states to the receiver and keeps
/// statistics and the last checkpoint.
class Reading {
 public:
  Reading(v1::SummarizeRequest& request, const Session::SummaryReceiver& receive)
      : request_(request), receive_(receive) {}

  /// Returns false when the receiver ends the call.
  bool take(v1::SummarizeResponse& message) {
    verify(message, "a message of the summary");
    statistics_.take(message.mutable_statistics());
    if (message.has_checkpoint()) take_checkpoint(message.checkpoint());
    auto* fields = message.has_events()   ? message.mutable_events()->mutable_fields()
                   : message.has_states() ? message.mutable_states()->mutable_fields()
                                          : nullptr;
    if (fields != nullptr) {
      fields_.take(fields);
      if (message.continues()) return true;
      *fields = fields_.finish();
      handed_out_ = true;
    }
    if (message.has_price()) price_ = message.price();
    const bool wanted = !receive_ || receive_(message);
    if (message.has_run_status()) {
      last_ = message;
      *last_.mutable_statistics() = statistics_.finish();
      *last_.mutable_price() = price_;
      if (!request_.checkpoint().empty())
        last_.mutable_checkpoint()->set_data(request_.checkpoint());
    }
    return wanted;
  }

  /// Whether a new stream for `request_` would pass nothing to the receiver twice.
  bool may_begin_again() const { return !handed_out_; }
  v1::SummarizeResponse& last() { return last_; }

 private:
  void take_checkpoint(const v1::CheckpointPart& part) {
    if (part.offset() != checkpoint_.size())
      throw CorruptReply("a part of the checkpoint of step " + std::to_string(part.step()) +
                         " is missing");
    checkpoint_ += part.data();
    if (checkpoint_.size() < part.size()) return;
    request_.set_checkpoint(std::move(checkpoint_));
    checkpoint_.clear();
    handed_out_ = false;
  }

  v1::SummarizeRequest& request_;
  const Session::SummaryReceiver& receive_;
  Assembly statistics_, fields_;
  std::string checkpoint_;
  v1::Price price_;
  bool handed_out_ = false;
  v1::SummarizeResponse last_;
};

}  // namespace

v1::SummarizeResponse Session::summarize(v1::SummarizeRequest request,
                                         const SummaryReceiver& receive) const {
  request.set_session_id(id());
  request.set_checksum(connection_->options.checksums);
  const Deadline deadline(connection_->options.compute_timeout);
  for (auto waiting = connection_->patience(deadline);;) {
    Reading reading(request, receive);
    grpc::ClientContext context;
    deadline.limit(context);
    const CancelOnStop cancel(connection_->options.stop, context);
    const auto reader = connection_->stub->Summarize(&context, request);
    v1::SummarizeResponse message;
    bool wanted = true;
    while (wanted && reader->Read(&message)) wanted = reading.take(message);
    if (!wanted) context.TryCancel();
    const grpc::Status status = reader->Finish();
    if (status.ok() || !wanted) return std::move(reading.last());
    if (!reading.may_begin_again() || !waiting.allows_another(status))
      throw connection_->error(status);
  }
}

}  // namespace stiefel::client
