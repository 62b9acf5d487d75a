#include <algorithm>
#include <utility>

#include "client/cpp/assembly.h"
#include "client/cpp/replies.h"
#include "client/cpp/whole_reply.h"
#include "stiefel/client/session.h"

namespace stiefel::client {
namespace {

/// Reads the streams of one Linearize: joins the messages of each result, checks what the protocol
/// promises of them, and passes every result to the receiver once.
class Reading {
 public:
  Reading(const v1::LinearizeRequest& request, const Session::LinearizationReceiver& receive)
      : request_(request), receive_(receive) {}

  void begin() {
    fields_ = {};
    before_ = -1;
    has_price_ = false;
    last_.Clear();
  }

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
    if (message.step() <= passed_on_) return true;
    passed_on_ = message.step();
    return !receive_ || receive_(message);
  }

  bool has_progressed() const { return false; }
  bool begins_anew_after(const Error&) const { return false; }
  v1::LinearizeResponse& last() { return last_; }

 private:
  void check(const v1::LinearizeResponse& message) {
    const bool blocks = request_.vectors().shape_size() == 3;
    const auto found =
        std::ranges::find(message.fields(), blocks ? "vectors" : "matrix", &v1::Field::name);
    require(found != message.fields().end() && found->value().shape_size() == (blocks ? 3 : 2),
            "a result has no vectors");
    require(message.step() > before_ && message.step() <= request_.to(),
            "its results are not in order");
    before_ = message.step();
  }

  const v1::LinearizeRequest& request_;
  const Session::LinearizationReceiver& receive_;
  Assembly fields_;
  std::int64_t before_ = -1;     // of this stream
  std::int64_t passed_on_ = -1;  // by all streams
  bool has_price_ = false;
  v1::LinearizeResponse last_;
};

}  // namespace

v1::LinearizeResponse Session::linearize(v1::LinearizeRequest request,
                                         const LinearizationReceiver& receive) const {
  request.set_session_id(id());
  Reading reading(request, receive);
  return whole_reply(*connection_, *recreation_, id(), request.to(), reading, [&](auto& context) {
    return connection_->stub->Linearize(&context, request);
  });
}

}  // namespace stiefel::client
