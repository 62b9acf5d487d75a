#include <optional>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/convert/tangents/lyapunov_answer.h"
#include "server/convert/work_price.h"

namespace stiefel::server {
namespace {

/// Moves tangent vectors slice by slice, and sends what Answer makes of them when it is there. If
/// `reports`, messages between say how far the call is.
template <class Request, class Response, class Answer, bool reports>
class TangentCall final : public SlicedStream<Response> {
  using Base = SlicedStream<Response>;

 public:
  TangentCall(Host& host, CallLog log, JobKind kind, SessionLease session, const Request& request,
              const TangentPrice& price, MemoryLease memory)
      : Base(host, std::move(log), kind),
        step_cost_(session->step_cost() + price.of_step / instructions_a_nanosecond),
        memory_(std::move(memory)),
        answer_(std::in_place, std::move(session), request, price.total, memory_.bytes()) {
    // A spectrum that reports its progress may end before its last step.
    this->begin(kind, Permit::Kind::stream, price.total, price.total, reports);
  }

 private:
  using Base::stop;

  bool makes_next() const override { return answer_ && !answer_->made(); }
  grpc::Status make() override {
    return stoppable(stop(), [this] { return answer_->make(); }).value_or(errors::cancelled());
  }
  bool save() override { return answer_->save(); }
  std::expected<Progress, grpc::Status> slice(Response& message) override {
    if (!answer_->has_results()) {
      const auto status =
          stoppable(stop(), [this] { return answer_->advance(slice_steps(step_cost_), stop()); });
      if (!status) return std::unexpected(errors::cancelled());
      if (!status->ok()) return std::unexpected(*status);
    }
    const bool due = reports && ++slices_ >= slices_between_messages;
    if (!answer_->has_results() && !due) return Progress::no_message;
    slices_ = 0;
    return answer_->next(message) ? Progress::last_message : Progress::message;
  }
  void free() noexcept override { answer_.reset(); }
  std::int64_t computed_steps() const override { return answer_ ? answer_->computed_steps() : 0; }

  static constexpr int slices_between_messages = 32;

  const double step_cost_;  // nanoseconds, with the vectors
  MemoryLease memory_;
  std::optional<Answer> answer_;
  int slices_ = 0;
};

template <class Response, class Answer, bool reports, class Request>
Begun<grpc::ServerWriteReactor<Response>> moved_vectors(Host& host,
                                                        grpc::CallbackServerContext& context,
                                                        CallLog& log, const Request& request) {
  auto session = find_session(host, context, request.session_id());
  if (!session) return session.error();
  if (auto status = check_step("from", request.from()); !status.ok()) return status;
  if (auto status = check_step("to", request.to(), request.from()); !status.ok()) return status;
  if (request.every() < 0)
    return errors::invalid("every", std::to_string(request.every()), "must be at least 0");
  if (const auto members = (*session)->scene().members().size(); members > 0)
    return errors::invalid("session_id", std::to_string(members) + " members",
                           "the scene must have no `members`");
  const TangentPrice price = price_of(**session, request);
  const JobKind kind = kind_with(**session, price.of_step);
  MemoryLease memory(log.account().memory(), memory_price({held_by(request), price.bytes}));
  return new TangentCall<Request, Response, Answer, reports>(
      host, std::move(log), kind, *std::move(session), request, price, std::move(memory));
}

}  // namespace

Service::Writing<v1::LinearizeResponse> Service::Linearize(Context& context, CallLog& log,
                                                           const v1::LinearizeRequest& request) {
  return moved_vectors<v1::LinearizeResponse, LinearizeAnswer, false>(host_, context, log, request);
}

Service::Writing<v1::LyapunovSpectrumResponse> Service::LyapunovSpectrum(
    Context& context, CallLog& log, const v1::LyapunovSpectrumRequest& request) {
  return moved_vectors<v1::LyapunovSpectrumResponse, LyapunovAnswer, true>(host_, context, log,
                                                                           request);
}

}  // namespace stiefel::server
