#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "server/sessions/session.h"

namespace stiefel::server {

/// A state as it travels from server to server.
struct Checkpoint {
  std::int64_t step;
  std::vector<double> saved;
};

/// `foreign`: of a server with another key, or of another format. Nothing in it can be believed.
enum class CheckpointFault { corrupt, other_scene, other_numerics, foreign };
struct CheckpointRefusal {
  CheckpointFault fault;
  std::string numerics_id;  ///< other_numerics: of the server that wrote it
};

/// Opaque to clients: format, name of the key, numerics id, SHA-256 of the scene's identity, step,
/// doubles, and the HMAC-SHA256 of all that by the first of the session's keys.
std::string encode_checkpoint(const Session& session, const Simulation& simulation);

/// How many they are.
std::size_t checkpoint_bytes(const Session& session);

/// For a session of the same resolved scene and numerics id. Believes bytes only when one of the
/// session's keys signed them and all numbers are finite; whether the state is near the manifold it
/// does not ask, because methods leave it legitimately.
std::expected<Checkpoint, CheckpointRefusal> decode_checkpoint(const Session& session,
                                                               std::string_view bytes);

}  // namespace stiefel::server
