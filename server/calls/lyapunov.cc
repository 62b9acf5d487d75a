#include <optional>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/errors.h"
#include "server/convert/linearize.h"
#include "server/convert/memory_price.h"
#include "server/convert/work_price.h"

namespace stiefel::server {
namespace {

/// Moves the vectors slice by slice, and sends the numbers when they are there.
class LyapunovCall final : public SlicedStream<v1::LyapunovSpectrumResponse> {
 public:
  LyapunovCall(Host& host, CallLog log, JobKind kind, SessionLease session,
               const v1::LyapunovSpectrumRequest& request, double step_cost, double price,
               MemoryLease memory)
      : SlicedStream(host, std::move(log), kind),
        step_cost_(step_cost),
        memory_(std::move(memory)),
        answer_(std::in_place, std::move(session), request, price, memory_.bytes()) {
    begin(kind, Permit::Kind::stream, price, price);
  }

 private:
  bool makes_next() const override { return answer_ && !answer_->made(); }
  grpc::Status make() override {
    return stoppable(stop(), [this] { return answer_->make(); }).value_or(stopped(host_.lifecycle));
  }
  std::expected<Progress, grpc::Status> slice(v1::LyapunovSpectrumResponse& message) override {
    if (!answer_->has_results()) {
      const auto status =
          stoppable(stop(), [this] { return answer_->advance(slice_steps(step_cost_), stop()); });
      if (!status) return std::unexpected(stopped(host_.lifecycle));
      if (!status->ok()) return std::unexpected(*status);
    }
    if (!answer_->has_results() && ++slices_ < slices_between_messages) return Progress::no_message;
    slices_ = 0;
    return answer_->next(message) ? Progress::last_message : Progress::message;
  }
  void free() noexcept override { answer_.reset(); }
  std::int64_t computed_steps() const override { return answer_ ? answer_->computed_steps() : 0; }

  /// The slices after which a message reports the progress if there is nothing else to send.
  static constexpr int slices_between_messages = 256;

  const double step_cost_;  // nanoseconds, with the vectors
  MemoryLease memory_;
  std::optional<LyapunovAnswer> answer_;
  int slices_ = 0;
};

}  // namespace

Service::Writing<v1::LyapunovSpectrumResponse> Service::LyapunovSpectrum(
    Context& context, CallLog& log, const v1::LyapunovSpectrumRequest& request) {
  auto session = find_session(host_, context, request.session_id());
  if (!session) return session.error();
  if (auto status = check_step("from", request.from()); !status.ok()) return status;
  if (auto status = check_step("to", request.to(), request.from()); !status.ok()) return status;
  if (request.every() < 0)
    return errors::invalid("every", std::to_string(request.every()), "must be at least 0");
  const LyapunovPrice price = lyapunov_price(**session, request);
  const JobKind kind = kind_with(**session, price.of_step);
  const double step_cost = (*session)->step_cost() + price.of_step / instructions_a_nanosecond;
  MemoryLease memory(log.account().memory(), memory_price({held_by(request), price.bytes}));
  return new LyapunovCall(host_, std::move(log), kind, *std::move(session), request, step_cost,
                          price.total, std::move(memory));
}

}  // namespace stiefel::server
