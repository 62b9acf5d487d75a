#include "server/convert/messages.h"

#include <algorithm>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/parts.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {
namespace {

v1::Field to_field(const SummaryArray& array) {
  v1::Field field;
  field.set_name(array.name);
  v1::Tensor& tensor = *field.mutable_value();
  for (const std::size_t extent : array.shape) tensor.add_shape(extent);
  if (array.type != SummaryArray::Type::count) {
    tensor.set_data_type(array.type == SummaryArray::Type::complex ? v1::DATA_TYPE_COMPLEX128
                                                                   : v1::DATA_TYPE_FLOAT64);
    tensor.set_data(array.numbers.data(), array.numbers.size() * sizeof(double));
    return field;
  }
  std::vector<std::int64_t> counts = array.counts;
  if (array.name == "outcome")
    for (std::int64_t& count : counts) {
      v1::RunStatus status;
      to_proto(RunStatus{static_cast<Outcome>(count), std::nullopt}, &status);
      count = status.outcome();
    }
  tensor.set_data_type(v1::DATA_TYPE_INT64);
  tensor.set_data(counts.data(), counts.size() * sizeof(std::int64_t));
  return field;
}

}  // namespace

void StreamMessages::add_scene(const SceneDescription& resolved) {
  for (const SceneArray& array : arrays_of(resolved)) scene_arrays_.add(to_field(array));
}

void StreamMessages::pack(const Session& session, const std::vector<std::size_t>& fields,
                          Batch& batch, EncodedCheckpoint checkpoint, v1::StreamResponse& message) {
  message.mutable_steps()->Assign(batch.steps.begin(), batch.steps.end());
  message.mutable_times()->Assign(batch.times.begin(), batch.times.end());
  message.clear_sample_continues();
  message.clear_checkpoint();
  message.clear_scene_arrays();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const int index = static_cast<int>(i);
    auto* field =
        index < message.fields_size() ? message.mutable_fields(index) : message.add_fields();
    describe_field(session, fields[i], batch.size(), false, field);
    field->clear_whole_shape();
    field->clear_offset();
    field->mutable_value()->mutable_data()->swap(batch.fields[i]);
  }
  checkpoint_ = std::move(checkpoint);
  checkpoint_sent_ = 0;
  if (batch.size() == 0) {
    if (!empty()) next(message);
    return;
  }
  step_ = batch.steps.back();
  time_ = batch.times.back();
  if (batch.size() > 1 || sample_bytes(session, fields) <= max_reply_bytes) return;
  for (auto& field : *message.mutable_fields()) sample_.add(std::move(field));
  next(message);
}

void StreamMessages::unpack(v1::StreamResponse& message, Batch& batch) {
  for (int i = 0; i < message.fields_size(); ++i)
    message.mutable_fields(i)->mutable_value()->mutable_data()->swap(
        batch.fields[static_cast<std::size_t>(i)]);
}

void StreamMessages::next(v1::StreamResponse& message) {
  message.Clear();
  if (!scene_arrays_.empty()) {
    scene_arrays_.take(part_bytes, message.mutable_scene_arrays());
  } else if (!sample_.empty()) {
    message.add_steps(step_);
    message.add_times(time_);
    sample_.take(part_bytes, message.mutable_fields());
    message.set_sample_continues(!sample_.empty());
  } else if (!checkpoint_.bytes.empty()) {
    next_checkpoint_part(message);
  }
}

void StreamMessages::next_checkpoint_part(v1::StreamResponse& message) {
  v1::CheckpointPart& part = *message.mutable_checkpoint();
  const std::string& bytes = checkpoint_.bytes;
  part.set_step(checkpoint_.step);
  part.set_size(bytes.size());
  part.set_offset(checkpoint_sent_);
  part.set_data(bytes.substr(checkpoint_sent_, part_bytes));
  checkpoint_sent_ += part.data().size();
  if (checkpoint_sent_ == bytes.size()) checkpoint_ = {};
}

SummaryMessages::SummaryMessages(const Session& session, const SummaryDescription& what)
    : session_(session), members_(std::max<std::size_t>(1, session.scene().members().size())) {
  for (const std::string& name : what.fields)
    fields_.push_back(find_field(session.fields(), name).value());
  if (fields_.empty()) fields_ = session.default_fields();
  for (const std::size_t index : fields_)
    event_numbers_ += field_size(session.fields(), index) / members_;
}

void SummaryMessages::add(std::vector<Event> events) {
  std::ranges::move(events, std::back_inserter(events_));
}

void SummaryMessages::add(std::vector<StateAtTime> states) {
  std::ranges::move(states, std::back_inserter(states_));
}

void SummaryMessages::add(const std::vector<SummaryArray>& statistics) {
  for (const SummaryArray& array : statistics) statistics_.add(to_field(array));
}

template <class Items>
void SummaryMessages::split_fields(const Items& items, bool by_members) {
  constexpr std::size_t list_bytes = 40;  // of steps, times and the like
  const std::size_t each = (by_members ? state_bytes() : event_bytes()) + list_bytes;
  batch_ = std::min(items.size(), std::max<std::size_t>(1, max_reply_bytes / each));
  std::size_t from = 0;
  for (const std::size_t index : fields_) {
    const std::size_t size = field_size(session_.fields(), index) / (by_members ? 1 : members_);
    v1::Field whole;
    describe_field(session_, index, batch_, !by_members, &whole);
    const bool narrow = is_float(session_, index);
    std::string& data = *whole.mutable_value()->mutable_data();
    data.reserve(batch_ * size * (narrow ? sizeof(float) : sizeof(double)));
    for (std::size_t i = 0; i < batch_; ++i) {
      const double* one = items[i].fields.data() + from;
      if (!narrow) data.append(reinterpret_cast<const char*>(one), size * sizeof(double));
      for (std::size_t k = 0; narrow && k < size; ++k) {
        const auto number = static_cast<float>(one[k]);
        data.append(reinterpret_cast<const char*>(&number), sizeof number);
      }
    }
    from += size;
    fields_left_.add(std::move(whole));
  }
}

template <class Items, class Batch, class Write>
void SummaryMessages::next_batch(Items& items, bool by_members, Batch& batch, const Write& write) {
  if (fields_left_.empty()) split_fields(items, by_members);
  fields_left_.take(max_reply_bytes, batch.mutable_fields());
  const auto end = items.begin() + static_cast<std::ptrdiff_t>(batch_);
  std::for_each(items.begin(), end, write);
  if (fields_left_.empty()) items.erase(items.begin(), end);
}

void SummaryMessages::next(v1::SummarizeResponse& message) {
  if (!events_.empty())
    next_batch(events_, false, *message.mutable_events(), [&](const Event& event) {
      auto& batch = *message.mutable_events();
      batch.add_events(static_cast<std::uint32_t>(event.event));
      batch.add_steps(event.step);
      batch.add_fractions(event.fraction);
      batch.add_times(event.time);
      if (!session_.scene().members().empty())
        batch.add_members(static_cast<std::uint32_t>(event.member));
    });
  else if (!states_.empty())
    next_batch(states_, true, *message.mutable_states(), [&](const StateAtTime& state) {
      message.mutable_states()->add_steps(state.step);
      message.mutable_states()->add_times(state.time);
    });
  else if (!checkpoint_.empty())
    return next_checkpoint(*message.mutable_checkpoint());
  else
    return statistics_.take(max_reply_bytes, message.mutable_statistics());
  message.set_continues(!fields_left_.empty());
}

void SummaryMessages::next_checkpoint(v1::CheckpointPart& part) {
  part.set_step(checkpoint_step_);
  part.set_size(checkpoint_.size());
  part.set_offset(checkpoint_sent_);
  part.set_data(checkpoint_.substr(checkpoint_sent_, part_bytes));
  checkpoint_sent_ += part.data().size();
  if (checkpoint_sent_ == checkpoint_.size()) checkpoint_.clear();
}

}  // namespace stiefel::server
