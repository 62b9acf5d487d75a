#include "server/convert/stream_messages.h"

#include "server/convert/convert.h"
#include "server/convert/parts.h"
#include "server/scheduling/failpoint.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {

void StreamMessages::add_scene(const SceneDescription& resolved) {
  for (const SceneArray& array : arrays_of(resolved)) scene_arrays_.add(to_field(array));
}

void StreamMessages::pack(const Session& session, const std::vector<std::size_t>& fields,
                          Batch& batch, EncodedCheckpoint checkpoint, v1::StreamResponse& message) {
  failpoint("stream.pack");
  message.mutable_steps()->Assign(batch.steps.begin(), batch.steps.end());
  message.mutable_times()->Assign(batch.times.begin(), batch.times.end());
  message.clear_sample_continues();
  message.clear_checkpoint();
  message.clear_scene_arrays();
  message.clear_price();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const int index = static_cast<int>(i);
    auto* field =
        index < message.fields_size() ? message.mutable_fields(index) : message.add_fields();
    describe_field(session, session.fields()[fields[i]], batch.size(), field);
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
  failpoint("stream.next");
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

}  // namespace stiefel::server
