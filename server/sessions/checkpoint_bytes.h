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

enum class CheckpointFault { corrupt, other_scene, other_numerics };
struct CheckpointRefusal {
  CheckpointFault fault;
  std::string numerics_id;  ///< other_numerics: of the server that wrote it
};

/// Opaque to clients: magic, format version, numerics id, hash of the scene, step, doubles,
/// checksum.
std::string encode_checkpoint(const Session& session, const Simulation& simulation);

/// How many they are.
std::size_t checkpoint_bytes(const Session& session);

/// For a session of the same resolved scene and numerics id; never trusts the bytes.
std::expected<Checkpoint, CheckpointRefusal> decode_checkpoint(const Session& session,
                                                               std::string_view bytes);

}  // namespace stiefel::server
