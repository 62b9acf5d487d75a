#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stiefel/scene.h"

namespace stiefel::server {

/// Returns the SHA-256 (32 bytes) of a resolved description: of the names, the shapes and the bits
/// of all its values. Equal exactly for equal scenes.
std::string identity_of(const SceneDescription& resolved);

/// The paths of the fields that a description sets, in order, each with the SHA-256 of its value.
/// The parts of `body` ("body.moments") follow `body` itself, which has no digest.
using FieldDigests = std::vector<std::pair<std::string, std::string>>;
FieldDigests field_digests(const SceneDescription& description);

/// Returns the FNV-1a hash, 64 bits. A change of one byte always changes it.
std::uint64_t hash(std::string_view bytes);

}  // namespace stiefel::server
