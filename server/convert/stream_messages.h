#pragma once

#include <string>
#include <vector>

#include "server/convert/parts.h"
#include "server/sessions/sampling.h"
#include "stiefel/v1/run.pb.h"

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

}  // namespace stiefel::server
