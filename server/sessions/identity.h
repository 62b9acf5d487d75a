#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "stiefel/scene.h"

namespace stiefel::server {

/// Returns the SHA-256 (32 bytes) of a resolved description: of the names, the shapes and the bits
/// of all its values. Equal exactly for equal scenes.
std::string identity_of(const SceneDescription& resolved);

/// Returns the FNV-1a hash, 64 bits. A change of one byte always changes it.
std::uint64_t hash(std::string_view bytes);

/// A digest of all that may change the bits of a state (build_fingerprint), 16 hexadecimal digits.
/// Two servers with the same id compute the same states.
const std::string& numerics_id();

}  // namespace stiefel::server
