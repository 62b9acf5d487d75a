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

/// Moves the vectors slice by slice, and sends each result when it is there.
class LinearizeCall final : public SlicedStream<v1::LinearizeResponse> {
 public:
  LinearizeCall(Host& host, CallLog log, JobKind kind, SessionLease session,
                const v1::LinearizeRequest& request, double step_cost, double price,
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
    return stoppable(stop(), [this] { return answer_->make(); })
        .value_or(stopped(host_.lifecycle));
  }
  std::expected<Progress, grpc::Status> slice(v1::LinearizeResponse& message) override {
    if (!answer_->has_message()) {
      const auto status = stoppable(
          stop(), [this] { return answer_->advance(slice_steps(step_cost_), stop()); });
      if (!status) return std::unexpected(stopped(host_.lifecycle));
      if (!status->ok()) return std::unexpected(*status);
    }
    if (!answer_->has_message()) return Progress::no_message;
    return answer_->next(message) ? Progress::last_message : Progress::message;
  }
  void free() noexcept override { answer_.reset(); }
  std::int64_t computed_steps() const override { return answer_ ? answer_->computed_steps() : 0; }

  const double step_cost_;  // nanoseconds, with the vectors
  MemoryLease memory_;
  std::optional<LinearizeAnswer> answer_;
};

}  // namespace

Service::Writing<v1::LinearizeResponse> Service::Linearize(Context& context, CallLog& log,
                                                           const v1::LinearizeRequest& request) {
  auto session = find_session(host_, context, request.session_id());
  if (!session) return session.error();
  if (auto status = check_step("from", request.from()); !status.ok()) return status;
  if (auto status = check_step("to", request.to(), request.from()); !status.ok()) return status;
  if (request.every() < 0)
    return errors::invalid("every", std::to_string(request.every()), "must be at least 0");
  const double work =
      linearize_work(**session, request, (*session)->start_for(request.from()));
  const double of_step = work_of_vectors(**session, request);
  const JobKind kind = kind_with(**session, of_step);
  const double step_cost = (*session)->step_cost() + of_step / instructions_a_nanosecond;
  MemoryLease memory(log.account().memory(),
                     memory_price({held_by(request), linearize_workspace(**session, request)}));
  return new LinearizeCall(host_, std::move(log), kind, *std::move(session), request, step_cost,
                           work, std::move(memory));
}

}  // namespace stiefel::server
