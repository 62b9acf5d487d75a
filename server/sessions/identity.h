#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stiefel/scene.h"

namespace stiefel::server {

/// SHA-256 of a resolved description, the same exactly for the same scene: of every field its
/// names, its shapes and the bits of its numbers. 32 bytes.
std::string identity_of(const SceneDescription& resolved);

/// The fields that a description has, by their paths in their order, each with the SHA-256 of its
/// value. The parts of `body` ("body.moments") follow on it.
using FieldDigests = std::vector<std::pair<std::string, std::string>>;
FieldDigests field_digests(const SceneDescription& description);

/// FNV-1a, 64 bits. Changing one byte always changes it.
std::uint64_t hash(std::string_view bytes);

}  // namespace stiefel::server
