#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "server/sessions/session.h"

namespace stiefel::server {

/// A decoded checkpoint: the state that Simulation::save wrote at `step`.
struct Checkpoint {
  std::int64_t step;
  std::vector<double> saved;
};

/// Why a checkpoint is refused. `foreign`: signed with a key that this server does not have, or in
/// another version of the format; nothing in it can be trusted.
enum class CheckpointFault { corrupt, other_scene, other_numerics, foreign };
struct CheckpointRefusal {
  CheckpointFault fault;
  std::string numerics_id;  ///< for other_numerics: that of the server that wrote it
};

/// Encodes a simulation's state as bytes opaque to clients: format, name of the key, numerics id,
/// SHA-256 of the scene's identity, step, doubles, and the HMAC-SHA256 of all that with the first
/// of the session's keys.
std::string encode_checkpoint(const Session& session, const Simulation& simulation);

/// Returns the length of the session's checkpoints in bytes.
std::size_t checkpoint_bytes(const Session& session);

/// Decodes a checkpoint of the same resolved scene and numerics id. Accepts it only when one of the
/// session's keys signed it and all numbers are finite. Does not check how near the state is to the
/// manifold, because methods may leave it legitimately.
std::expected<Checkpoint, CheckpointRefusal> decode_checkpoint(const Session& session,
                                                               std::string_view bytes);

}  // namespace stiefel::server
