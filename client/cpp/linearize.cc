#include <algorithm>
#include <utility>

#include "client/cpp/assembly.h"
#include "client/cpp/late.h"
#include "client/cpp/replies.h"
#include "stiefel/client/session.h"

namespace stiefel::client {
namespace {

/// Joins the messages of one result, and checks what the protocol promises of them.
class Reading {
 public:
  Reading(const v1::LinearizeRequest& request, const Session::LinearizationReceiver& receive)
      : request_(request), receive_(receive) {}

  /// Returns false when the receiver ends the call.
  bool take(v1::LinearizeResponse& message) {
    require(!last_.has_run_status(), "it goes on after its end");
    if (!std::exchange(has_price_, true)) check_present(message, {"price"});
    fields_.take(message.mutable_fields());
    if (message.has_run_status()) check_end(message.run_status(), message.step(), request_.to());
    if (message.result_continues()) return true;
    *message.mutable_fields() = fields_.finish();
    const bool is_result = !message.fields().empty();
    if (message.has_run_status()) {
      require(is_result || message.run_status().outcome() != v1::OUTCOME_REACHED,
              "its last result is missing");
      last_ = message;
    }
    if (!is_result) return true;
    check(message);
    return !receive_ || receive_(message);
  }

  v1::LinearizeResponse& last() { return last_; }

 private:
  void check(const v1::LinearizeResponse& message) {
    const bool blocks = request_.vectors().shape_size() == 3;
    const auto found = std::ranges::find(message.fields(), blocks ? "vectors" : "matrix",
                                         &v1::Field::name);
    require(found != message.fields().end() && found->value().shape_size() == (blocks ? 3 : 2),
            "a result has no vectors");
    require(message.step() > before_ && message.step() <= request_.to(),
            "its results are not in order");
    before_ = message.step();
  }

  const v1::LinearizeRequest& request_;
  const Session::LinearizationReceiver& receive_;
  Assembly fields_;
  std::int64_t before_ = -1;
  bool has_price_ = false;
  v1::LinearizeResponse last_;
};

}  // namespace

v1::LinearizeResponse Session::linearize(v1::LinearizeRequest request,
                                         const LinearizationReceiver& receive) const {
  request.set_session_id(id());
  const Deadline deadline(connection_->options.compute_timeout);
  auto waiting = connection_->patience(deadline);
  auto recoveries = connection_->patience_to_recover(deadline);
  std::int64_t passed_on = -1;
  const LinearizationReceiver once = [&](const v1::LinearizeResponse& result) {
    if (result.step() <= passed_on) return true;
    passed_on = result.step();
    return !receive || receive(result);
  };
  while (true) {
    Reading reading(request, once);
    grpc::ClientContext context;
    deadline.limit(context);
    recreation_->route(context);
    const CancelOnStop cancel(connection_->options.stop, context);
    const auto reader = connection_->stub->Linearize(&context, request);
    v1::LinearizeResponse message;
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
