#include <chrono>
#include <limits>
#include <optional>
#include <stop_token>
#include <utility>

#include "proto/checksum/checksum.h"
#include "server/admission/admission.h"
#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
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

/// Slices after which a message says how far the call is, when there is nothing else to send.
constexpr int slices_between_messages = 256;
/// An ensemble of more has more than a slice of work before its first step.
constexpr std::size_t few_members = 64;
/// Its slices are so many times longer: each fetches all members from memory, once for all of its
/// steps.
constexpr int longer_for_many = 16;

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
  return std::unexpected(
      errors::invalid("checkpoint", value, "must be what Summarize returned: it is damaged"));
}

/// Computes in slices on a pool, and rests while a message is written. Deletes itself.
class SummarizeCall final : public grpc::ServerWriteReactor<v1::SummarizeResponse>, private Job {
 public:
  /// The request lives as long as the call.
  SummarizeCall(Host& host, Pool& pool, CallLog log, SessionLease session,
                const v1::SummarizeRequest& request)
      : host_(host),
        pool_(pool),
        log_(std::move(log)),
        session_(std::move(session)),
        request_(request),
        shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
    const double price = (*session_)->work((*session_)->start_for(request.from()), request.to());
    log_.price(price);
    log_.begin();
    const grpc::Status admitted = admit(ticket_, log_.account(), Ticket::Kind::stream, price);
    host_.lifecycle.enter();
    if (!admitted.ok()) {
      end(admitted);
    } else {
      Job::bill(log_.account().share(), price);
      pool_.submit(this);
    }
  }

  void OnCancel() override { stop_.request_stop(); }
  void OnWriteDone(bool ok) override {
    log_.written();
    if (!ok) stop_.request_stop();
    pool_.submit(this);
  }
  void OnDone() override {
    Host& host = host_;
    delete this;
    host.lifecycle.leave();
  }

 private:
  bool run_slice() noexcept override;
  /// One slice of work; an error ends the call.
  grpc::Status work();
  grpc::Status start();
  void advance();
  void shut_down();
  void send();
  void end(const grpc::Status& status);
  /// Where the next checkpoint is due.
  std::int64_t mark() const;
  bool leaving() const { return stop_.stop_requested() && !host_.lifecycle.stopping(); }

  Host& host_;
  Pool& pool_;
  CallLog log_;
  Ticket ticket_;
  std::optional<SessionLease> session_;
  const v1::SummarizeRequest& request_;
  MemoryLease memory_;
  std::optional<Summary> summary_;
  std::optional<SummaryMessages> messages_;
  v1::Price price_;
  v1::SummarizeResponse message_;  // being written
  int longer_ = 1;                 // than a slice of a single motion
  std::int64_t steps_ = 1;         // of a slice
  std::int64_t last_mark_ = 0;
  int slices_ = 0;
  bool done_ = false;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;
};

bool SummarizeCall::run_slice() noexcept {
  grpc::Status status;
  try {
    if (leaving())
      status = errors::cancelled();
    else if (!messages_ || (messages_->empty() && !done_))
      status = work();
    if (status.ok() && leaving()) status = errors::cancelled();
    if (status.ok()) {
      const bool silent = !messages_ || (messages_->empty() && !done_);
      log_.worked();
      if (silent && slices_ < slices_between_messages / longer_) return true;
      send();
      return false;
    }
  } catch (...) {
    status = errors::from_current_exception();
  }
  end(status);
  return false;
}

grpc::Status SummarizeCall::work() {
  failpoint("call.summarize");
  if (!summary_) {
    if (host_.lifecycle.refusing()) return errors::shutting_down();
    return start();
  }
  ++slices_;
  if (host_.lifecycle.stopping()) {
    shut_down();
  } else {
    advance();
  }
  // What was being read when the server stopped it may be incomplete.
  if (summary_->interrupted()) return errors::shutting_down();
  if (!done_) return grpc::Status::OK;
  messages_->add(summary_->statistics());
  return grpc::Status::OK;
}

grpc::Status SummarizeCall::start() {
  Session& session = **session_;
  auto what = from_proto(request_);
  if (!what) return what.error();
  auto summary = Summary::prepare(session.scene(), *std::move(what));
  if (!summary) return errors::invalid(summary.error());
  memory_ = MemoryLease(log_.account().memory(), summary_memory(session, *summary));
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
                             "must be what Summarize returned: it is damaged");
  }
  const auto times = static_cast<std::uint64_t>(request_.times_size());
  to_proto(session.work(std::min(summary->step(), request_.to()), request_.to()),
           summary->statistics_bytes() + times * messages_->state_bytes(),
           summary->reads_on_the_way() ? v1::PRICE_BOUND_AT_LEAST : bound_of_steps(session),
           &price_);
  longer_ = has_many(session) ? longer_for_many : 1;
  steps_ = slice_steps(session.step_cost());
  last_mark_ = summary->step();
  summary_.emplace(*std::move(summary));
  return grpc::Status::OK;
}

std::int64_t SummarizeCall::mark() const {
  const std::int64_t every = request_.checkpoint_every(), from = request_.from();
  constexpr auto never = std::numeric_limits<std::int64_t>::max();
  if (every == 0) return never;
  const std::int64_t done = last_mark_ < from ? -1 : (last_mark_ - from) / every;
  return done + 1 > (never - from) / every ? never : from + (done + 1) * every;
}

/// The length of a slice follows the clock, because reading may cost more than stepping; what is
/// computed does not depend on it.
void SummarizeCall::advance() {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const std::int64_t due = mark();
  summary_->advance(steps_, due, stop_.get_token());
  const std::chrono::duration<double, std::nano> taken = Clock::now() - begin;
  if (taken.count() > 2 * longer_ * slice_nanoseconds)
    steps_ = std::max<std::int64_t>(1, steps_ / 2);
  else if (taken.count() < longer_ * slice_nanoseconds / 2)
    steps_ = std::min(2 * steps_, longer_ * slice_steps((*session_)->step_cost()));
  if (summary_->interrupted()) return;
  messages_->add(summary_->take_events());
  messages_->add(summary_->take_states());
  done_ = summary_->done();
  if (summary_->step() < due || done_) return;
  last_mark_ = due;
  messages_->add_checkpoint(due, encode_summary(**session_, digest_of(request_), summary_->save()));
}

/// The server goes down: what there is, and on request where another server goes on.
void SummarizeCall::shut_down() {
  if (request_.return_checkpoint())
    messages_->add_checkpoint(summary_->step(),
                              encode_summary(**session_, digest_of(request_), summary_->save()));
  summary_->cancel();
  done_ = true;
}

void SummarizeCall::send() {
  failpoint("call.summary_message");
  slices_ = 0;
  message_.Clear();
  message_.set_step(summary_->step());
  message_.set_computed_steps(summary_->computed_steps());
  if (price_.bound() != v1::PRICE_BOUND_UNSPECIFIED) {
    message_.mutable_price()->Swap(&price_);
    price_.Clear();
  }
  if (!messages_->empty()) messages_->next(message_);
  const bool last = done_ && messages_->empty();
  if (last) {
    v1::RunStatus& status = *message_.mutable_run_status();
    to_proto(summary_->status(), &status);
    if (!summary_->status().reached())
      status.set_message(to_sentence(summary_->status(), (*session_)->scene(), summary_->rate()));
  }
  if (request_.checksum()) message_.set_checksum(wire::checksum(message_));
  if (last) return end(grpc::Status::OK);
  log_.writing();
  StartWrite(&message_);
}

void SummarizeCall::end(const grpc::Status& status) {
  log_.finish(status, summary_ ? summary_->computed_steps() : 0);
  summary_.reset();
  messages_.reset();
  session_.reset();
  ticket_.give_back();
  if (status.ok())
    StartWriteAndFinish(&message_, grpc::WriteOptions(), status);
  else
    Finish(status);
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
    return new SummarizeCall(host_, pool, std::move(log), *std::move(session), *request);
  } catch (...) {
    return refuse(errors::from_current_exception());
  }
}

}  // namespace stiefel::server
