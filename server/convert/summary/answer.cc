#include "server/convert/summary/answer.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "proto/checksum/checksum.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/price.h"
#include "server/convert/summary/checkpoint.h"
#include "server/convert/summary/request.h"
#include "server/pricing/memory_price.h"
#include "server/sessions/checkpoints/summary_checkpoint.h"
#include "stiefel/simulation.h"

namespace stiefel::server {
namespace {

/// The bytes that a summary keeps for each of the times at which it reads the state.
constexpr std::uint64_t time_bytes = 32;

}  // namespace

grpc::Status SummarizeAnswer::start(MemoryBudget& memory) {
  const auto times = static_cast<std::uint64_t>(request_.times_size());
  memory_ = MemoryLease(memory, reading_memory(request_.ByteSizeLong()) + times * time_bytes);
  auto what = from_proto(request_);
  if (!what) return what.error();
  auto summary = Summary::prepare(session_->scene(), *std::move(what));
  if (!summary) return errors::invalid(summary.error());
  memory_.grow(summary_memory(*session_, *summary));
  messages_.emplace(*session_, summary->description());
  if (const auto status = find_first_state(*summary); !status.ok()) return status;
  write_price(*summary);
  last_mark_ = summary->step();
  summary_.emplace(*std::move(summary));
  return grpc::Status::OK;
}

grpc::Status SummarizeAnswer::find_first_state(Summary& summary) {
  if (!request_.checkpoint().empty()) {
    const auto saved = open_checkpoint(*session_, request_);
    if (!saved) return saved.error();
    if (*saved) return summary.restore(**saved) ? grpc::Status::OK : damaged_checkpoint(request_);
    checkpoint_ignored_ = true;
  }
  auto simulation = session_->lease(request_.from());
  std::vector<double> saved(simulation->saved_size());
  simulation->save(saved);
  summary.start_at(simulation->step(), saved);
  session_->give_back(std::move(simulation));
  return grpc::Status::OK;
}

void SummarizeAnswer::write_price(const Summary& summary) {
  const auto times = static_cast<std::uint64_t>(request_.times_size());
  to_proto(session_->work(std::min(summary.step(), request_.to()), request_.to()),
           summary.statistics_bytes() + times * messages_->state_bytes(),
           summary.reads_on_the_way() ? v1::PRICE_BOUND_AT_LEAST : v1::PRICE_BOUND_EXPECTED,
           &price_);
}

std::int64_t SummarizeAnswer::next_mark() const {
  const std::int64_t every = request_.checkpoint_every(), from = request_.from();
  constexpr auto never = std::numeric_limits<std::int64_t>::max();
  if (every == 0) return never;
  const std::int64_t done = last_mark_ < from ? -1 : (last_mark_ - from) / every;
  return done + 1 > (never - from) / every ? never : from + (done + 1) * every;
}

void SummarizeAnswer::advance(std::int64_t steps, const std::stop_token& stop) {
  summary_->advance(steps, next_mark(), stop);
}

void SummarizeAnswer::collect() {
  messages_->add(summary_->take_events());
  messages_->add(summary_->take_states());
  done_ = summary_->done();
  if (done_) return messages_->add(summary_->statistics());
  const std::int64_t due = next_mark();
  if (summary_->step() < due) return;
  last_mark_ = due;
  add_checkpoint(due);
}

void SummarizeAnswer::cut_short() {
  if (request_.return_checkpoint()) add_checkpoint(summary_->step());
  summary_->cancel();
  done_ = true;
  if (!interrupted()) messages_->add(summary_->statistics());
}

void SummarizeAnswer::add_checkpoint(std::int64_t step) {
  messages_->add_checkpoint(step, encode_summary(*session_, digest_of(request_), summary_->save()));
}

bool SummarizeAnswer::next(v1::SummarizeResponse& message) {
  message.Clear();
  message.set_step(summary_->step());
  message.set_computed_steps(summary_->computed_steps());
  if (price_.bound() != v1::PRICE_BOUND_UNSPECIFIED) {
    message.mutable_price()->Swap(&price_);
    price_.Clear();
    message.set_checkpoint_ignored(checkpoint_ignored_);
  }
  if (has_results()) messages_->next(message);
  const bool last = done_ && !has_results();
  if (last) {
    v1::RunStatus& status = *message.mutable_run_status();
    to_proto(summary_->status(), &status);
    if (!summary_->status().reached())
      status.set_message(to_sentence(summary_->status(), session_->scene(), summary_->rate()));
  }
  if (request_.checksum()) message.set_checksum(wire::checksum(message));
  return last;
}

}  // namespace stiefel::server
