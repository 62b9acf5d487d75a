#pragma once

#include <cstdint>
#include <expected>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/sessions/server_session.h"

namespace stiefel::server {

/// Why a checkpoint is refused.
enum class CheckpointFault { corrupt, other_scene, other_numerics };
struct CheckpointRefusal {
  CheckpointFault fault;
  std::string numerics_id;  ///< for other_numerics: that of the server that wrote it
};

/// The formats of checkpoints: of a state, of a summary in progress, and of the growth of tangent
/// vectors. The last character is the version.
inline constexpr std::string_view state_format = "STFLCKP4", summary_format = "STFLSUM3",
                                  growth_format = "STFLLYA1";

/// Returns bytes that are opaque to clients: format, numerics id, the session's identity,
/// `content`, and the SHA-256 of all that, which finds damage and not forgery.
std::string seal_checkpoint(const Session& session, std::string_view format,
                            std::initializer_list<std::string_view> content);
/// Returns the content, a view into `bytes`, of an undamaged checkpoint of the same resolved scene
/// and numerics id.
std::expected<std::string_view, CheckpointRefusal> verify_checkpoint(const Session& session,
                                                                     std::string_view format,
                                                                     std::string_view bytes);

/// A decoded checkpoint: the state that Simulation::save wrote at `step`.
struct Checkpoint {
  std::int64_t step;
  std::vector<double> saved;
};

/// Seals a simulation's state: its step and its numbers.
std::string encode_checkpoint(const Session& session, const Simulation& simulation);
/// Seals a state as Simulation::save wrote it.
std::string encode_checkpoint(const Session& session, std::int64_t step,
                              std::span<const double> saved);
/// Returns the length of the session's checkpoints in bytes.
std::size_t checkpoint_bytes(const Session& session);
/// Decodes a checkpoint whose numbers must be finite. Does not check how near the state is to the
/// manifold, because methods may leave it legitimately.
std::expected<Checkpoint, CheckpointRefusal> decode_checkpoint(const Session& session,
                                                               std::string_view bytes);

}  // namespace stiefel::server
