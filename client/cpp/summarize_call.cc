#include <algorithm>
#include <utility>

#include "client/cpp/assembly.h"
#include "client/cpp/replies.h"
#include "client/cpp/whole_reply.h"
#include "stiefel/client/session.h"

namespace stiefel::client {
namespace {

template <class Numbers>
void drop_first(Numbers* numbers, int count) {
  numbers->erase(numbers->begin(), numbers->begin() + std::min(count, numbers->size()));
}

/// Removes the first of the `rows` rows of each array.
void drop_first_rows(Fields* arrays, int count, int rows) {
  if (count == 0) return;
  for (v1::Field& array : *arrays) {
    v1::Tensor& value = *array.mutable_value();
    const std::size_t row = value.data().size() / static_cast<std::size_t>(rows);
    value.mutable_data()->erase(0, row * static_cast<std::size_t>(count));
    if (value.shape_size() > 0) value.set_shape(0, static_cast<std::uint64_t>(rows - count));
  }
}

/// Reads the streams of one Summarize: passes every event and state to the receiver once, and keeps
/// statistics and the last checkpoint.
class Reading {
 public:
  Reading(v1::SummarizeRequest& request, const Session::SummaryReceiver& receive)
      : request_(request),
        given_(request.checkpoint()),
        receive_(receive),
        of_events_(request.fields(), 3, false),
        of_states_(request.fields(), 3, true) {}

  /// Prepares for the messages of a new stream, which begins at the request's checkpoint.
  void begin() {
    statistics_ = fields_ = {};
    checkpoint_.clear();
    seen_ = at_checkpoint_;
  }

  /// Returns false when the receiver ends the call.
  bool take(v1::SummarizeResponse& message) {
    statistics_.take(message.mutable_statistics());
    if (message.has_events() || message.has_states()) {
      Fields* const fields = message.has_events() ? message.mutable_events()->mutable_fields()
                                                  : message.mutable_states()->mutable_fields();
      fields_.take(fields);
      if (message.continues()) return true;
      *fields = fields_.finish();
      message.has_events() ? check(message.events()) : check(message.states());
      drop_passed_on(message);
    }
    if (message.has_checkpoint()) take_checkpoint(message.checkpoint());
    if (!has_price_) check_present(message, {"price"});
    if (!std::exchange(has_price_, true)) price_ = message.price();
    const bool wanted = !receive_ || receive_(message);
    if (message.has_run_status()) {
      last_ = message;
      *last_.mutable_statistics() = statistics_.finish();
      check_end();
      *last_.mutable_price() = price_;
      if (!request_.checkpoint().empty())
        last_.mutable_checkpoint()->set_data(request_.checkpoint());
    }
    return wanted;
  }

  /// Returns whether the error is the refusal of a checkpoint that an earlier stream sent. The
  /// request then has the caller's checkpoint again.
  bool begins_anew_after(const Error& error) {
    if (request_.checkpoint() == given_ || !Recreation::refuses_checkpoint(error)) return false;
    request_.set_checkpoint(given_);
    at_checkpoint_ = {};
    return true;
  }

  /// Returns whether a checkpoint has come since the last call of this function.
  bool has_progressed() { return std::exchange(progressed_, false); }

  v1::SummarizeResponse& last() { return last_; }

 private:
  void check(const v1::EventBatch& events) {
    const int count = events.steps_size();
    require(events.events_size() == count && events.fractions_size() == count &&
                events.times_size() == count &&
                (events.members().empty() || events.members_size() == count) &&
                std::ranges::all_of(
                    events.events(),
                    [&](auto event) { return std::cmp_less(event, request_.events_size()); }),
            "its events have lists of different lengths, or are unknown");
    of_events_.check(events.fields(), count);
  }

  void check(const v1::StateBatch& states) {
    const int count = states.steps_size();
    require(states.times_size() == count && seen_.states + count <= request_.times_size() &&
                std::equal(states.times().begin(), states.times().end(),
                           request_.times().begin() + static_cast<int>(seen_.states)),
            "its states are not at the times asked for");
    of_states_.check(states.fields(), count);
  }

  /// Checks that all has come: every state, unless the run stopped or an event may have ended it.
  void check_end() const {
    check_outcome(last_.run_status());
    require(!fields_.begun(), "the last event or state is incomplete");
    require(last_.run_status().outcome() != v1::OUTCOME_REACHED ||
                std::ranges::any_of(request_.events(), &v1::Event::terminal) ||
                seen_.states == request_.times_size(),
            "states are missing");
    check_statistics(last_.statistics(), request_, last_.run_status().outcome());
  }

  /// Numbers of events and of states.
  struct Counts {
    std::int64_t events = 0, states = 0;
  };

  /// Removes from a message the events and states that an earlier stream brought.
  void drop_passed_on(v1::SummarizeResponse& message) {
    if (message.has_events()) {
      v1::EventBatch& events = *message.mutable_events();
      const int count = events.steps_size(), old = old_of(count, seen_.events, passed_on_.events);
      drop_first(events.mutable_events(), old);
      drop_first(events.mutable_steps(), old);
      drop_first(events.mutable_fractions(), old);
      drop_first(events.mutable_times(), old);
      drop_first(events.mutable_members(), old);
      drop_first_rows(events.mutable_fields(), old, count);
      if (old == count) message.clear_events();
    } else {
      v1::StateBatch& states = *message.mutable_states();
      const int count = states.steps_size(), old = old_of(count, seen_.states, passed_on_.states);
      drop_first(states.mutable_steps(), old);
      drop_first(states.mutable_times(), old);
      drop_first_rows(states.mutable_fields(), old, count);
      if (old == count) message.clear_states();
    }
  }

  /// Counts a batch, and returns how many of it were passed on before.
  static int old_of(int count, std::int64_t& seen, std::int64_t& passed_on) {
    const auto old = std::clamp<std::int64_t>(passed_on - seen, 0, count);
    seen += count;
    passed_on = std::max(passed_on, seen);
    return static_cast<int>(old);
  }

  void take_checkpoint(const v1::CheckpointPart& part) {
    if (part.offset() != checkpoint_.size())
      throw CorruptReply("a part of the checkpoint of step " + std::to_string(part.step()) +
                         " is missing");
    checkpoint_ += part.data();
    require(checkpoint_.size() <= part.size(), "a checkpoint is too long");
    if (checkpoint_.size() < part.size()) return;
    request_.set_checkpoint(std::exchange(checkpoint_, {}));
    at_checkpoint_ = seen_;
    progressed_ = true;
  }

  v1::SummarizeRequest& request_;
  std::string given_;  // the caller's checkpoint
  const Session::SummaryReceiver& receive_;
  Assembly statistics_, fields_;
  std::string checkpoint_;
  bool progressed_ = false;
  Counts passed_on_;      // by all streams
  Counts seen_;           // up to where the present stream is
  Counts at_checkpoint_;  // up to the request's checkpoint
  Layout of_events_, of_states_;
  v1::Price price_;
  bool has_price_ = false;
  v1::SummarizeResponse last_;
};

}  // namespace

v1::SummarizeResponse Session::summarize(v1::SummarizeRequest request,
                                         const SummaryReceiver& receive) const {
  request.set_session_id(id());
  Reading reading(request, receive);
  return whole_reply(*connection_, *recreation_, id(), request.to(), reading, [&](auto& context) {
    return connection_->stub->Summarize(&context, request);
  });
}

}  // namespace stiefel::client
