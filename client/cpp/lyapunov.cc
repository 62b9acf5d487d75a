#include <string>
#include <utility>

#include "client/cpp/late.h"
#include "client/cpp/replies.h"
#include "stiefel/client/session.h"

namespace stiefel::client {
namespace {

/// Reads the messages of one call, and checks what the protocol promises of them.
class GrowthReading {
 public:
  GrowthReading(const v1::LyapunovSpectrumRequest& request, const Session::SpectrumReceiver& receive)
      : request_(request), receive_(receive) {}

  /// Returns false when the receiver ends the call.
  bool take(v1::LyapunovSpectrumResponse& message) {
    if (!std::exchange(has_price_, true)) check_present(message, {"price"});
    if (message.has_checkpoint()) {
      const auto& part = message.checkpoint();
      require(part.offset() == checkpoint_.size() &&
                  checkpoint_.size() + part.data().size() <= part.size(),
              "a part of the checkpoint is missing");
      checkpoint_ += part.data();
      complete_ = checkpoint_.size() == part.size();
    }
    if (!message.exponents().empty()) {
      require(message.log_gali_size() == message.exponents_size() - 1 && message.step() > before_,
              "its results are incomplete or not in order");
      before_ = message.step();
    }
    if (message.has_run_status()) {
      check_end(message.run_status(), message.step(), request_.to());
      require(message.run_status().outcome() != v1::OUTCOME_REACHED ||
                  (message.errors_size() == message.exponents_size() &&
                   !message.exponents().empty() && complete_),
              "its last result is missing");
      check_present(message, {"verdict", "reason"});
      last_ = message;
      last_.mutable_checkpoint()->set_offset(0);
      last_.mutable_checkpoint()->set_data(std::move(checkpoint_));
    } else if (message.exponents().empty()) {
      return true;
    }
    return !receive_ || receive_(message);
  }

  v1::LyapunovSpectrumResponse& last() { return last_; }

 private:
  const v1::LyapunovSpectrumRequest& request_;
  const Session::SpectrumReceiver& receive_;
  std::int64_t before_ = -1;
  std::string checkpoint_;
  bool has_price_ = false, complete_ = false;
  v1::LyapunovSpectrumResponse last_;
};

}  // namespace

v1::LyapunovSpectrumResponse Session::lyapunov(v1::LyapunovSpectrumRequest request,
                                               const SpectrumReceiver& receive) const {
  request.set_session_id(id());
  const Deadline deadline(connection_->options.compute_timeout);
  auto waiting = connection_->patience(deadline);
  auto recoveries = connection_->patience_to_recover(deadline);
  std::int64_t passed_on = -1;
  const SpectrumReceiver once = [&](const v1::LyapunovSpectrumResponse& result) {
    if (result.step() <= passed_on && !result.has_run_status()) return true;
    passed_on = result.step();
    return !receive || receive(result);
  };
  while (true) {
    GrowthReading reading(request, once);
    grpc::ClientContext context;
    deadline.limit(context);
    recreation_->route(context);
    const CancelOnStop cancel(connection_->options.stop, context);
    const auto reader = connection_->stub->LyapunovSpectrum(&context, request);
    v1::LyapunovSpectrumResponse message;
    bool wanted = true, answered = false;
    while (wanted && reader->Read(&message)) {
      if (!std::exchange(answered, true)) recreation_->check_build(context, false);
      wanted = reading.take(message);
    }
    if (!wanted) {
      context.TryCancel();
      reader->Finish();
      return std::move(reading.last());
    }
    const grpc::Status status = finish(context, *reader);
    if (status.ok()) {
      require(reading.last().has_run_status(), "the call ends without saying how the run ended");
      return std::move(reading.last());
    }
    recreation_->check_build(context, true);
    const Error error = connection_->error(status, context);
    if (!waiting.allows_another(status) && !recreation_->recovers(error, deadline, recoveries))
      throw with_standing(error, *connection_, id(), request.to());
  }
}

}  // namespace stiefel::client
