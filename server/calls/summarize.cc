#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>
#include <stop_token>
#include <utility>

#include "proto/checksum/checksum.h"
#include "server/calls/limits.h"
#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/calls/stopped.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/price.h"
#include "server/convert/summary/messages.h"
#include "server/convert/summary/request.h"
#include "server/limits/failpoint.h"
#include "server/pricing/memory_price.h"
#include "server/sessions/checkpoints/summary_checkpoint.h"
#include "server/sessions/numerics_id.h"

namespace stiefel::server {
namespace {

/// The slices after which a message reports the progress if there is nothing else to send.
constexpr int slices_between_messages = 256;
/// A slice that advances `width` groups of members is longer than that of one motion by the factor
/// `width / groups_in_a_slice`, at least 1 and at most `longest`, so that each group computes for
/// about 0.1 ms after it was fetched from memory.
constexpr std::size_t groups_in_a_slice = 16, longest = 16;

/// Whether the ensemble has more than a slice of work before its first step.
bool has_many(const Session& session) { return session.scene().members().size() > few_members; }

OrStatus<std::string_view> open_checkpoint(const Session& session,
                                           const v1::SummarizeRequest& request) {
  const auto saved = decode_summary(session, digest_of(request), request.checkpoint());
  if (saved) return *saved;
  const std::string value = std::to_string(request.checkpoint().size()) + " bytes";
  switch (saved.error().fault) {
    case SummaryFault::other_numerics:
      return std::unexpected(
          errors::checkpoint_of_other_numerics(saved.error().numerics_id, numerics_id()));
    case SummaryFault::other_scene:
      return std::unexpected(
          errors::invalid("checkpoint", value, "must come from a session of the same scene"));
    case SummaryFault::other_request:
      return std::unexpected(
          errors::invalid("checkpoint", value, "must come from a Summarize of the same request"));
    case SummaryFault::foreign:
      return std::unexpected(errors::invalid(
          "checkpoint", value, "must come from a server with this server's --checkpoint-key"));
    case SummaryFault::corrupt:
      break;
  }
  return std::unexpected(errors::invalid("checkpoint", value,
                                         "is damaged: must be the bytes that Summarize returned"));
}

/// Advances a summary step by step. Its messages carry the results, checkpoints and, at least every
/// 256 slices, the progress.
class SummarizeWork final : public StreamWork<v1::SummarizeResponse> {
 public:
  /// The request and the account must outlive this object.
  SummarizeWork(const Lifecycle& lifecycle, Account& account, SessionLease session,
                const v1::SummarizeRequest& request)
      : lifecycle_(lifecycle), account_(account), session_(std::move(session)), request_(request) {}

  std::expected<Progress, grpc::Status> slice(const std::stop_token& stop,
                                              v1::SummarizeResponse& message) override;
  std::int64_t computed_steps() const override { return summary_ ? summary_->computed_steps() : 0; }

 private:
  /// Whether the next message needs more slices.
  bool needs_more_slices() const { return !messages_ || (messages_->empty() && !done_); }
  grpc::Status work(const std::stop_token& stop);
  grpc::Status start();
  void advance(const std::stop_token& stop);
  void shut_down();
  Progress write(v1::SummarizeResponse& message);
  /// Returns the step at which the next checkpoint is due.
  std::int64_t mark() const;

  const Lifecycle& lifecycle_;
  Account& account_;
  const SessionLease session_;
  const v1::SummarizeRequest& request_;
  MemoryLease memory_;
  std::optional<Summary> summary_;
  std::optional<SummaryMessages> messages_;
  v1::Price price_;
  int longer_ = 1;          // the factor by which slices are longer than those of a single motion
  std::int64_t steps_ = 1;  // of a slice
  std::int64_t last_mark_ = 0;
  int slices_ = 0;
  bool done_ = false;
};

std::expected<Progress, grpc::Status> SummarizeWork::slice(const std::stop_token& stop,
                                                           v1::SummarizeResponse& message) {
  if (needs_more_slices())
    if (const auto status = work(stop); !status.ok()) return std::unexpected(status);
  if (needs_more_slices() && slices_ < slices_between_messages / longer_)
    return Progress::no_message;
  return write(message);
}

/// Runs one slice; an error ends the call.
grpc::Status SummarizeWork::work(const std::stop_token& stop) {
  if (!summary_) {
    const auto begun = stoppable(stop, [this] { return start(); });
    return begun ? *begun : stopped(lifecycle_);
  }
  ++slices_;
  if (lifecycle_.stopping()) {
    // A checkpoint can be made only when all members are at one step.
    if (!summary_->aligned()) return errors::shutting_down();
    shut_down();
  } else {
    advance(stop);
  }
  // A reading that the server's stop interrupted may be incomplete.
  if (summary_->interrupted()) return errors::shutting_down();
  if (!done_) return grpc::Status::OK;
  messages_->add(summary_->statistics());
  return grpc::Status::OK;
}

grpc::Status SummarizeWork::start() {
  Session& session = *session_;
  auto what = from_proto(request_);
  if (!what) return what.error();
  auto summary = Summary::prepare(session.scene(), *std::move(what));
  if (!summary) return errors::invalid(summary.error());
  memory_ = MemoryLease(account_.memory(), summary_memory(session, *summary));
  messages_.emplace(session, summary->description());
  if (request_.checkpoint().empty()) {
    auto simulation = session.lease(request_.from());
    std::vector<double> saved(simulation->saved_size());
    simulation->save(saved);
    summary->start_at(simulation->step(), saved);
    session.give_back(std::move(simulation));
  } else {
    const auto saved = open_checkpoint(session, request_);
    if (!saved) return saved.error();
    if (!summary->restore(*saved))
      return errors::invalid("checkpoint", std::to_string(request_.checkpoint().size()) + " bytes",
                             "is damaged: must be the bytes that Summarize returned");
  }
  const auto times = static_cast<std::uint64_t>(request_.times_size());
  to_proto(session.work(std::min(summary->step(), request_.to()), request_.to()),
           summary->statistics_bytes() + times * messages_->state_bytes(),
           summary->reads_on_the_way() ? v1::PRICE_BOUND_AT_LEAST : bound_of_steps(session),
           &price_);
  longer_ =
      static_cast<int>(std::clamp<std::size_t>(summary->width() / groups_in_a_slice, 1, longest));
  steps_ = slice_steps(session.step_cost());
  last_mark_ = summary->step();
  summary_.emplace(*std::move(summary));
  return grpc::Status::OK;
}

std::int64_t SummarizeWork::mark() const {
  const std::int64_t every = request_.checkpoint_every(), from = request_.from();
  constexpr auto never = std::numeric_limits<std::int64_t>::max();
  if (every == 0) return never;
  const std::int64_t done = last_mark_ < from ? -1 : (last_mark_ - from) / every;
  return done + 1 > (never - from) / every ? never : from + (done + 1) * every;
}

/// Adapts the length of slices to the clock, because reading may cost more than stepping. The
/// results do not depend on that length.
void SummarizeWork::advance(const std::stop_token& stop) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const std::int64_t due = mark();
  summary_->advance(steps_, due, stop);
  const std::chrono::duration<double, std::nano> taken = Clock::now() - begin;
  if (taken.count() > 2 * longer_ * slice_nanoseconds)
    steps_ = std::max<std::int64_t>(1, steps_ / 2);
  else if (taken.count() < longer_ * slice_nanoseconds / 2)
    steps_ = std::min(2 * steps_, longer_ * slice_steps(session_->step_cost()));
  if (summary_->interrupted()) return;
  messages_->add(summary_->take_events());
  messages_->add(summary_->take_states());
  done_ = summary_->done();
  if (summary_->step() < due || done_) return;
  last_mark_ = due;
  messages_->add_checkpoint(due, encode_summary(*session_, digest_of(request_), summary_->save()));
}

/// Ends the summary for a server that stops: with what there is and, on request, a checkpoint from
/// which another server goes on.
void SummarizeWork::shut_down() {
  if (request_.return_checkpoint())
    messages_->add_checkpoint(summary_->step(),
                              encode_summary(*session_, digest_of(request_), summary_->save()));
  summary_->cancel();
  done_ = true;
}

Progress SummarizeWork::write(v1::SummarizeResponse& message) {
  failpoint("call.summary_message");
  slices_ = 0;
  message.Clear();
  message.set_step(summary_->step());
  message.set_computed_steps(summary_->computed_steps());
  if (price_.bound() != v1::PRICE_BOUND_UNSPECIFIED) {
    message.mutable_price()->Swap(&price_);
    price_.Clear();
  }
  if (!messages_->empty()) messages_->next(message);
  const bool last = done_ && messages_->empty();
  if (last) {
    v1::RunStatus& status = *message.mutable_run_status();
    to_proto(summary_->status(), &status);
    if (!summary_->status().reached())
      status.set_message(to_sentence(summary_->status(), session_->scene(), summary_->rate()));
  }
  if (request_.checksum()) message.set_checksum(wire::checksum(message));
  return last ? Progress::last_message : Progress::message;
}

}  // namespace

grpc::ServerWriteReactor<v1::SummarizeResponse>* Service::Summarize(
    Context* context, const v1::SummarizeRequest* request) {
  CallLog log = open(context, "Summarize", request->session_id());
  const auto refuse = [&](const grpc::Status& status) {
    return new RefusedStream<v1::SummarizeResponse>(log, status);
  };
  try {
    auto session = find_session(host_, *context, request->session_id());
    if (!session) return refuse(session.error());
    if (const auto status = check_range(*request); !status.ok()) return refuse(status);
    Pool& pool = has_many(**session) ? host_.searches : host_.pool_for((*session)->step_cost());
    const double price = (*session)->work((*session)->start_for(request->from()), request->to());
    Account& account = log.account();
    return new SlicedStream<v1::SummarizeResponse>(
        host_, pool, std::move(log), Ticket::Kind::stream, price,
        std::make_unique<SummarizeWork>(host_.lifecycle, account, *std::move(session), *request));
  } catch (...) {
    return refuse(errors::from_current_exception());
  }
}

}  // namespace stiefel::server
