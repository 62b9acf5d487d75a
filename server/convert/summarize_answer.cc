#include "server/convert/summarize_answer.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "stiefel/simulation.h"

namespace stiefel::server {
namespace {

/// The bytes that a summary keeps for each of the times at which it reads the state.
constexpr std::uint64_t time_bytes = 32;

/// Returns a digest of everything in a request that determines its summary.
std::uint64_t digest_of(v1::SummarizeRequest request) {
  request.clear_session_id();
  request.clear_checkpoint();
  request.clear_checkpoint_every();
  request.clear_return_checkpoint();
  request.set_every(std::max<std::int64_t>(request.every(), 1));
  return hash(request.SerializeAsString());
}

std::string_view bytes_of(const std::uint64_t& digest) {
  return {reinterpret_cast<const char*>(&digest), sizeof digest};
}

}  // namespace

void SummarizeAnswer::read(MemoryBudget& memory) {
  const auto times = static_cast<std::uint64_t>(request_.times_size());
  memory_ = MemoryLease(memory, memory_price({held_by(request_), times * time_bytes}));
  what_ = from_proto(request_);
}

void SummarizeAnswer::make() {
  auto summary = Summary::prepare(session_->scene(), std::move(*what_));
  if (!summary) throw errors::invalid(summary.error());
  memory_.grow(memory_price({.workspace = summary_workspace(*session_, *summary),
                             .reply = summary->statistics_bytes(),
                             .reply_of = "quantities"}));
  summary_.emplace(*std::move(summary));
  if (!has_checkpoint_) go_to_first_state();
}

void SummarizeAnswer::go_to_first_state() {
  auto simulation = session_->acquire(summary_->description().from);
  std::vector<double> saved(simulation->saved_size());
  simulation->save(saved);
  summary_->start_at(simulation->step(), saved);
  session_->release(std::move(simulation));
}

void SummarizeAnswer::start() {
  if (has_checkpoint_) restore();
  messages_.emplace(*session_, summary_->description());
  if (request_.times_size() > 0 || request_.events_size() > 0)
    memory_.grow(memory_price({.reply = messages_->state_bytes()}));
  last_mark_ = summary_->step();
}

void SummarizeAnswer::restore() {
  const std::string& bytes = request_.checkpoint();
  const auto content = verify_checkpoint(*session_, summary_format, bytes);
  if (!content) throw errors::checkpoint_refused(content.error(), bytes.size(), "Summarize");
  const std::uint64_t digest = digest_of(request_);
  if (!content->starts_with(bytes_of(digest)))
    throw errors::invalid("checkpoint", std::to_string(bytes.size()) + " bytes",
                          "must come from a Summarize of the same request");
  if (!summary_->restore(content->substr(sizeof digest)))
    throw errors::checkpoint_refused({CheckpointFault::corrupt, {}}, bytes.size(), "Summarize");
}

std::int64_t SummarizeAnswer::next_mark() const {
  const std::int64_t every = request_.checkpoint_every(), from = request_.from();
  constexpr auto never = std::numeric_limits<std::int64_t>::max();
  if (every == 0) return never;
  const std::int64_t done = last_mark_ < from ? -1 : (last_mark_ - from) / every;
  return done + 1 > (never - from) / every ? never : from + (done + 1) * every;
}

void SummarizeAnswer::advance(double slice, const std::stop_token& stop) {
  summary_->advance(slice, next_mark(), stop);
}

void SummarizeAnswer::collect() {
  messages_->add(summary_->take_events());
  messages_->add(summary_->take_states());
  done_ = summary_->done();
  if (done_) return messages_->add(summary_->statistics());
  if (const std::int64_t due = next_mark(); summary_->step() >= due) {
    last_mark_ = due;
    add_checkpoint(due);
  }
}

bool SummarizeAnswer::save() {
  const bool asked = request_.return_checkpoint() || request_.checkpoint_every() > 0;
  if (asked && started() && !done() && summary_->aligned() && summary_->step() != last_mark_)
    add_checkpoint(last_mark_ = summary_->step());
  return has_results() || done();
}

void SummarizeAnswer::add_checkpoint(std::int64_t step) {
  const std::string saved = summary_->save();
  const std::uint64_t digest = digest_of(request_);
  messages_->add_checkpoint(step,
                            seal_checkpoint(*session_, summary_format, {bytes_of(digest), saved}));
}

bool SummarizeAnswer::next(v1::SummarizeResponse& message) {
  message.Clear();
  message.set_step(summary_->step());
  message.set_computed_steps(summary_->computed_steps());
  if (has_results()) messages_->next(message);
  // Members that an event has ended have no states at later times.
  const bool ends = std::ranges::any_of(request_.events(), &v1::Event::terminal);
  finite_ = finite_ &&
            (ends || (is_finite(message.events().fields()) &&
                      is_finite(message.states().fields()) && is_finite(message.statistics())));
  const bool last = done_ && !has_results();
  if (last) {
    v1::RunStatus& status = *message.mutable_run_status();
    to_proto(summary_->status(), &status);
    if (!summary_->status().reached())
      status.set_message(to_sentence(summary_->status(), session_->scene(), summary_->rate()));
    demand_finite(finite_, &status);
  }
  return last;
}

}  // namespace stiefel::server
