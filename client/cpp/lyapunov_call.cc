#include <string>
#include <utility>

#include "client/cpp/replies.h"
#include "client/cpp/whole_reply.h"
#include "stiefel/client/session.h"

namespace stiefel::client {
namespace {

/// Reads the streams of one call: checks what the protocol promises of them, and passes every
/// result to the receiver once.
class GrowthReading {
 public:
  GrowthReading(v1::LyapunovSpectrumRequest& request, const Session::SpectrumReceiver& receive)
      : request_(request), given_(request.checkpoint()), receive_(receive) {}

  void begin() {
    before_ = -1;
    checkpoint_.clear();
    has_price_ = complete_ = false;
    last_.Clear();
  }

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
      if (complete_ && !message.has_run_status()) {
        request_.set_checkpoint(std::exchange(checkpoint_, {}));
        progressed_ = true;
      }
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
    } else if (message.exponents().empty()) {  // how far the call is
      return !receive_ || receive_(message);
    }
    if (message.step() <= passed_on_ && !message.has_run_status()) return true;
    passed_on_ = message.step();
    return !receive_ || receive_(message);
  }

  /// Returns whether a checkpoint has come since the last call of this function.
  bool has_progressed() { return std::exchange(progressed_, false); }
  /// Returns whether the error is the refusal of a checkpoint that an earlier stream sent. The
  /// request then has the caller's checkpoint again.
  bool begins_anew_after(const Error& error) {
    if (request_.checkpoint() == given_ || !Recreation::refuses_checkpoint(error)) return false;
    request_.set_checkpoint(given_);
    return true;
  }
  v1::LyapunovSpectrumResponse& last() { return last_; }

 private:
  v1::LyapunovSpectrumRequest& request_;
  const std::string given_;  // the caller's checkpoint
  const Session::SpectrumReceiver& receive_;
  std::int64_t before_ = -1;     // of this stream
  std::int64_t passed_on_ = -1;  // by all streams
  std::string checkpoint_;
  bool has_price_ = false, complete_ = false, progressed_ = false;
  v1::LyapunovSpectrumResponse last_;
};

}  // namespace

v1::LyapunovSpectrumResponse Session::lyapunov(v1::LyapunovSpectrumRequest request,
                                               const SpectrumReceiver& receive) const {
  request.set_session_id(id());
  GrowthReading reading(request, receive);
  return whole_reply(*connection_, *recreation_, id(), request.to(), reading, [&](auto& context) {
    return connection_->stub->LyapunovSpectrum(&context, request);
  });
}

}  // namespace stiefel::client
