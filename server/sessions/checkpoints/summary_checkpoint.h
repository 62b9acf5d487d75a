#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>

#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/session.h"

namespace stiefel::server {

/// Why the checkpoint of a summary is refused. `foreign`: signed with a key that this server does
/// not have, or in another version of the format.
enum class SummaryFault { corrupt, foreign, other_scene, other_request, other_numerics };
struct SummaryRefusal {
  SummaryFault fault;
  std::string numerics_id;  ///< for other_numerics: that of the server that wrote the bytes
};

/// Encodes a summary in progress as bytes opaque to clients: magic, name of the key, numerics id,
/// hash of the scene, `digest` (the hash of the request), the bytes of Summary::save, and the
/// HMAC-SHA256 of all that.
std::string encode_summary(const Session& session, std::uint64_t digest, std::string_view saved);

/// Returns the bytes of Summary::save, a view into `bytes`, for a summary of the same resolved
/// scene, request and numerics id. Verifies the signature before it reads on.
std::expected<std::string_view, SummaryRefusal> decode_summary(const Session& session,
                                                               std::uint64_t digest,
                                                               std::string_view bytes);

}  // namespace stiefel::server
