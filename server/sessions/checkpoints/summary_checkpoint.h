#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>

#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/session.h"

namespace stiefel::server {

enum class SummaryFault { corrupt, foreign, other_scene, other_request, other_numerics };
struct SummaryRefusal {
  SummaryFault fault;
  std::string numerics_id;  ///< other_numerics: of the server that wrote it
};

/// A summary on its way as bytes, opaque to clients: magic, name of the key, numerics id, hash of
/// the scene, that of the request (`digest`), what Summary::save gave, HMAC-SHA256 of all that.
std::string encode_summary(const Session& session, std::uint64_t digest, std::string_view saved);

/// What Summary::save gave, for a summary of the same resolved scene, request and numerics id;
/// never trusts the bytes. `foreign`: signed by a key that this server does not have.
std::expected<std::string_view, SummaryRefusal> decode_summary(const Session& session,
                                                               std::uint64_t digest,
                                                               std::string_view bytes);

}  // namespace stiefel::server
