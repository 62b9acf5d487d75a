#pragma once

#include <string>
#include <vector>

#include "server/convert/parts.h"
#include "server/sessions/sampling.h"
#include "stiefel/v1/run.pb.h"

namespace stiefel::server {

/// The messages of a stream, in their order: arrays of the scene; a batch of samples, or one sample
/// in parts; the checkpoint of the last of them, or of a state between samples. Each has at most
/// `max_reply_bytes` of arrays.
class StreamMessages {
 public:
  /// The arrays of a scene. Before the first batch.
  void add_scene(const SceneDescription& resolved);
  /// Writes the first message of a batch, which is not to be filled further, over `message`, whose
  /// memory the next batch gets. `checkpoint`: what follows the samples, without bytes if
  /// nothing does. Everything before must have been taken.
  void pack(const Session& session, const std::vector<std::size_t>& fields, Batch& batch,
            EncodedCheckpoint checkpoint, v1::StreamResponse& message);

  /// Whether nothing is left for `next`.
  bool empty() const {
    return scene_arrays_.empty() && sample_.empty() && checkpoint_.bytes.empty();
  }
  /// Writes what comes next over `message`.
  void next(v1::StreamResponse& message);

 private:
  void next_checkpoint_part(v1::StreamResponse& message);

  Parts scene_arrays_;
  Parts sample_;  ///< a sample that is too large for a message
  std::int64_t step_ = 0;
  double time_ = 0;
  EncodedCheckpoint checkpoint_;
  std::size_t checkpoint_sent_ = 0;
};

}  // namespace stiefel::server
