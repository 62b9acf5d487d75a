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
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

/// The bytes that a summary keeps for each of the times at which it reads the state.
constexpr std::uint64_t time_bytes = 32;

std::string digest_of(v1::SummarizeRequest request) {
  request.clear_session_id();
  request.clear_checkpoint();
  request.clear_checkpoint_every();
  request.clear_return_checkpoint();
  request.set_every(std::max<std::int64_t>(request.every(), 1));
  const std::uint64_t digest = hash(request.SerializeAsString());
  return {reinterpret_cast<const char*>(&digest), sizeof digest};
}

/// Prepares a summary, with what a simulation of the session has of an ensemble's members.
std::unique_ptr<Summary> prepared(Session& session, const v1::SummarizeRequest& request,
                                  MemoryLease& memory) {
  const auto times = static_cast<std::uint64_t>(request.times_size());
  memory.grow(memory_price({held_by(request), times * time_bytes}));
  SimulationPtr begun;
  if (session.members_are_numbers()) begun = session.acquire(session.cursor());
  auto summary = value_of(Summary::prepare(session.scene(), from_proto(request), begun.get()));
  if (begun) session.release(std::move(begun));
  memory.grow(memory_price({.workspace = summary_workspace(session, *summary),
                            .reply = summary->statistics_bytes(),
                            .reply_of = "quantities"}));
  return summary;
}

}  // namespace

SummarizeAnswer::SummarizeAnswer(SessionRef session, const v1::SummarizeRequest& request,
                                 MemoryLease& memory)
    : session_(std::move(session)),
      request_(request),
      digest_(digest_of(request)),
      summary_(prepared(*session_, request, memory)),
      messages_(*session_, summary_->description()) {
  if (request.times_size() > 0 || request.events_size() > 0)
    memory.grow(memory_price({.reply = messages_.state_bytes()}));
  request.checkpoint().empty() ? go_to_first_state() : restore();
  last_mark_ = summary_->step();
}

void SummarizeAnswer::go_to_first_state() {
  if (request_.from() == 0) return;  // the summary's simulations are there
  auto simulation = session_->acquire(request_.from());
  std::vector<double> saved(simulation->saved_size());
  simulation->save(saved);
  summary_->start_at(simulation->step(), saved);
  session_->release(std::move(simulation));
}

void SummarizeAnswer::restore() {
  const std::string& bytes = request_.checkpoint();
  const auto content = verify_checkpoint(*session_, summary_format, bytes);
  if (!content) throw errors::checkpoint_refused(content.error(), bytes.size(), "Summarize");
  if (!content->starts_with(digest_))
    throw errors::invalid("checkpoint", std::to_string(bytes.size()) + " bytes",
                          "must come from a Summarize of the same request");
  if (!summary_->restore(content->substr(digest_.size())))
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
  if (summary_->interrupted()) throw Stopped();  // a reading may be incomplete
  messages_.add(summary_->take_events());
  messages_.add(summary_->take_states());
  if (summary_->done())
    messages_.add(summary_->statistics());
  else if (summary_->step() >= next_mark())
    add_checkpoint();
}

bool SummarizeAnswer::save(bool interrupted) {
  if (interrupted) return false;
  const bool asked = request_.return_checkpoint() || request_.checkpoint_every() > 0;
  if (asked && !summary_->done() && summary_->aligned() && summary_->step() != last_mark_)
    add_checkpoint();
  return has_results() || summary_->done();
}

void SummarizeAnswer::add_checkpoint() {
  last_mark_ = summary_->step();
  messages_.add_checkpoint(last_mark_,
                           seal_checkpoint(*session_, summary_format, {digest_, summary_->save()}));
}

bool SummarizeAnswer::next(v1::SummarizeResponse& message) {
  message.Clear();
  message.set_step(summary_->step());
  message.set_computed_steps(summary_->computed_steps());
  if (has_results()) messages_.next(message);
  // Members that an event has ended have no states at later times.
  const bool ends = std::ranges::any_of(request_.events(), &v1::Event::terminal);
  finite_ = finite_ &&
            (ends || (is_finite(message.events().fields()) &&
                      is_finite(message.states().fields()) && is_finite(message.statistics())));
  const bool last = summary_->done() && !has_results();
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
