#include "server/convert/stream_answer.h"

#include <utility>

#include "server/convert/convert.h"
#include "server/scheduling/memory_limit.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

/// The longest time for which a sample waits for others to fill a message.
constexpr std::chrono::milliseconds longest_wait{10};

}  // namespace

StreamAnswer::StreamAnswer(Session& session, std::vector<std::size_t> fields,
                           const Sampling::Range& range, std::function<Place()> take_place)
    : session_(session),
      fields_(std::move(fields)),
      take_place_(std::move(take_place)),
      place_(Cursor::is_large(session) ? take_place_() : nullptr),
      sampling_(session, fields_, range) {}

bool StreamAnswer::has_results() const {
  return sampling_.done() || sampling_.full() ||
         (!sampling_.empty() && Clock::now() - begin_ >= longest_wait);
}

void StreamAnswer::advance(const std::stop_token& stop) {
  if (Cursor::is_large(session_) && !place_) place_ = take_place_();
  if (sampling_.empty()) begin_ = Clock::now();
  sampling_.fill(stop);
  if (sampling_.cursor().stopped()) throw Stopped();
  if (sampling_.empty()) rest();
}

/// Gives the place back, and the simulation unless it is between two states or its state does not
/// fit into the memory.
void StreamAnswer::rest() {
  if (!place_) return;
  sampling_.suspend();
  place_ = nullptr;
  give_back_unused_stack();
}

bool StreamAnswer::next(v1::StreamResponse& message) {
  Batch batch = sampling_.take();
  message.mutable_steps()->Assign(batch.steps.begin(), batch.steps.end());
  message.mutable_times()->Assign(batch.times.begin(), batch.times.end());
  for (std::size_t i = 0; batch.size() > 0 && i < fields_.size(); ++i) {
    v1::Field* field = message.add_fields();
    describe_field(session_, fields_[i], batch.size(), false, field);
    *field->mutable_value()->mutable_data() = std::move(batch.fields[i]);
  }
  if (EncodedCheckpoint& checkpoint = batch.checkpoint; !checkpoint.bytes.empty()) {
    message.mutable_checkpoint()->set_step(checkpoint.step);
    message.mutable_checkpoint()->set_data(std::move(checkpoint.bytes));
  }
  message.set_computed_steps(sampling_.cursor().computed_steps());
  finite_ = finite_ && is_finite(message.fields());
  if (sampling_.done()) {
    to_proto(sampling_.cursor(), session_.scene(), message.mutable_run_status());
    demand_finite(finite_, message.mutable_run_status());
  }
  rest();
  return sampling_.done();
}

}  // namespace stiefel::server
