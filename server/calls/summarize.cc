#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/errors.h"
#include "server/convert/summarize_answer.h"
#include "server/convert/work_price.h"

namespace stiefel::server {
namespace {

/// The slices after which a message reports the progress if there is nothing else to send.
constexpr int slices_between_messages = 256;

/// The most members of an ensemble whose simulation takes at most a slice of work to make.
constexpr std::size_t few_members = 64;

/// Whether the ensemble has more than a slice of work before its first step.
bool has_many(const Session& session) { return session.scene().members().size() > few_members; }

/// Advances a summary slice by slice. At least every 256 slices a message is sent, which has the
/// progress alone if there are no results.
class SummarizeCall final : public SlicedStream<v1::SummarizeResponse> {
 public:
  SummarizeCall(Host& host, CallLog log, JobKind kind, SessionLease session,
                const v1::SummarizeRequest& request, const ReadingWork& reading, double price,
                double expected)
      : SlicedStream(host, std::move(log), kind),
        step_cost_(session->step_cost() +
                   reading.each / instructions_a_nanosecond /
                       static_cast<double>(std::max<std::int64_t>(request.every(), 1))),
        answer_(std::in_place, std::move(session), request, reading.total) {
    begin(kind, Permit::Kind::stream, price, expected);
  }

 private:
  bool makes_next() const override { return answer_->was_read() && !answer_->made(); }
  grpc::Status make() override {
    return until_stopped([this] { return answer_->make(); });
  }
  bool save() override { return answer_->save(); }
  std::expected<Progress, grpc::Status> slice(v1::SummarizeResponse& message) override;
  void free() noexcept override { answer_.reset(); }
  std::int64_t computed_steps() const override { return answer_ ? answer_->computed_steps() : 0; }

  /// Whether the next message needs more slices.
  bool needs_more_slices() const { return !answer_->has_results() && !answer_->done(); }
  /// Returns what `part` of the preparation returns, or the status of a stopped call.
  template <class Part>
  grpc::Status until_stopped(Part part) const {
    return stoppable(stop(), part).value_or(errors::cancelled());
  }
  grpc::Status work();
  grpc::Status start();
  void advance();

  const double step_cost_;  // nanoseconds, with the reading
  std::optional<SummarizeAnswer> answer_;
  double steps_ = 1;  // of a slice
  int slices_ = 0;
};

std::expected<Progress, grpc::Status> SummarizeCall::slice(v1::SummarizeResponse& message) {
  if (needs_more_slices())
    if (const auto status = work(); !status.ok()) return std::unexpected(status);
  if (needs_more_slices() && slices_ < slices_between_messages) return Progress::no_message;
  slices_ = 0;
  return answer_->next(message) ? Progress::last_message : Progress::message;
}

/// Runs one slice; an error ends the call.
grpc::Status SummarizeCall::work() {
  if (!answer_->was_read())
    return until_stopped([this] { return answer_->read(log_.account().memory()); });
  if (!answer_->started()) return start();
  if (answer_->price_reached()) return errors::price_reached(*answer_->price_reached());
  ++slices_;
  advance();
  // A reading that a stop interrupted may be incomplete.
  return answer_->interrupted() ? errors::cancelled() : grpc::Status::OK;
}

grpc::Status SummarizeCall::start() {
  if (const auto status = until_stopped([this] { return answer_->start(); }); !status.ok())
    return status;
  steps_ = slice_fraction(step_cost_);
  return grpc::Status::OK;
}

/// Adapts the length of slices to the clock, because stepping and reading may cost more than
/// predicted. The results do not depend on that length.
void SummarizeCall::advance() {
  using Clock = std::chrono::steady_clock;
  const auto before = Clock::now();
  // A slice on the worker kept for short calls is shorter.
  const double most = slice_fraction(step_cost_);
  steps_ = std::min(steps_, most);
  answer_->advance(steps_, stop());
  const std::chrono::duration<double, std::nano> taken = Clock::now() - before;
  if (taken.count() > 2 * slice_nanoseconds)
    steps_ = std::max(steps_ / 2, std::min(most, 1.0));
  else if (taken.count() < slice_nanoseconds / 2)
    steps_ = std::min(2 * steps_, most);
  if (!answer_->interrupted()) answer_->collect();
}

}  // namespace

Service::Writing<v1::SummarizeResponse> Service::Summarize(Context& context, CallLog& log,
                                                           const v1::SummarizeRequest& request) {
  auto session = find_session(host_, context, request.session_id());
  if (!session) return session.error();
  if (auto status = check_range(request); !status.ok()) return status;
  const ReadingWork reading = reading_work(**session, request);
  const JobKind kind = has_many(**session) ? JobKind::unsliced : kind_with(**session, reading.each);
  const std::int64_t start = (*session)->start_for(request.from());
  const std::int64_t every = std::max<std::int64_t>(request.every(), 1);
  const std::int64_t stops =
      (request.to() - request.from()) / (request.events().empty() ? every : 1) + 1;
  const double price = (*session)->most_work(start, request.to(), stops) + reading.total;
  const double expected = (*session)->work(start, request.to(), stops) + reading.total;
  return new SummarizeCall(host_, std::move(log), kind, *std::move(session), request, reading,
                           price, expected);
}

}  // namespace stiefel::server
