#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "server/convert/parts.h"
#include "server/sessions/sampling.h"
#include "server/sessions/server_session.h"
#include "stiefel/summary.h"
#include "stiefel/v1/run.pb.h"
#include "stiefel/v1/summary.pb.h"

namespace stiefel::server {

/// Makes the messages of a stream in their order: the arrays of the scene; then for each batch its
/// samples, or one sample in parts, and the checkpoint of its last sample or of a state between
/// samples. Each has at most `max_reply_bytes` of arrays.
class StreamMessages {
 public:
  /// Adds the arrays of a scene. Call it before the first batch.
  void add_scene(const SceneDescription& resolved);
  /// Writes the first message of a finished batch over `message`, which takes the batch's memory.
  /// `checkpoint` follows the samples; it has no bytes if there is none. Call it when `empty()`.
  void pack(const Session& session, const std::vector<std::size_t>& fields, Batch& batch,
            EncodedCheckpoint checkpoint, v1::StreamResponse& message);
  /// Gives the batch its memory back once the message that `pack` wrote is serialized, so that a
  /// stream holds a message once, as bytes, beside the batch that it fills.
  static void unpack(v1::StreamResponse& message, Batch& batch);

  /// Whether nothing is left for `next`.
  bool empty() const {
    return scene_arrays_.empty() && sample_.empty() && checkpoint_.bytes.empty();
  }
  /// Writes the next message over `message`.
  void next(v1::StreamResponse& message);

 private:
  void next_checkpoint_part(v1::StreamResponse& message);

  Parts scene_arrays_;
  Parts sample_;  ///< a sample that is too large for one message
  std::int64_t step_ = 0;
  double time_ = 0;
  EncodedCheckpoint checkpoint_;
  std::size_t checkpoint_sent_ = 0;
};

/// Collects what a Summarize has to send and makes messages of it, each with at most
/// `max_reply_bytes` of arrays.
class SummaryMessages {
 public:
  /// `session` must outlive this object.
  SummaryMessages(const Session& session, const SummaryDescription& what);

  void add(std::vector<Event> events);
  void add(std::vector<StateAtTime> states);
  void add_checkpoint(std::int64_t step, std::string bytes) {
    checkpoint_step_ = step;
    checkpoint_ = std::move(bytes);
    checkpoint_sent_ = 0;
  }
  void add(const std::vector<SummaryArray>& statistics);

  bool empty() const {
    return events_.empty() && states_.empty() && fields_left_.empty() && checkpoint_.empty() &&
           statistics_.empty();
  }
  /// Writes the next message over `message`, which must be empty.
  void next(v1::SummarizeResponse& message);
  /// The bytes of the fields of one event, and of one state with all its members.
  std::size_t event_bytes() const { return event_numbers_ * sizeof(double); }
  std::size_t state_bytes() const { return event_bytes() * members_; }

 private:
  void next_checkpoint(v1::CheckpointPart& part);
  /// Takes the fields of the first items, events or states, that fit into a message. An item holds
  /// numbers field after field: of one member or, with `by_members`, of all.
  template <class Items>
  void split_fields(const Items& items, bool by_members);
  /// Writes the next fields and, by `write`, the rest of their items.
  template <class Items, class Batch, class Write>
  void next_batch(Items& items, bool by_members, Batch& batch, const Write& write);

  const Session& session_;
  std::vector<std::size_t> fields_;  ///< indices of the fields in the session
  std::size_t members_;
  std::size_t event_numbers_ = 0;
  std::deque<Event> events_;
  std::deque<StateAtTime> states_;
  std::size_t batch_ = 0;  ///< the events or states whose fields are being sent
  Parts fields_left_;      ///< the fields of these that are left
  std::int64_t checkpoint_step_ = 0;
  std::string checkpoint_;
  std::size_t checkpoint_sent_ = 0;
  Parts statistics_;
};

}  // namespace stiefel::server
