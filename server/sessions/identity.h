#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "stiefel/scene.h"

namespace stiefel::server {

/// A resolved description as bytes, the same exactly for the same scene: of every field its names,
/// its shapes and the bits of its numbers.
std::string identity_of(const SceneDescription& resolved);

/// FNV-1a, 64 bits. Changing one byte always changes it.
std::uint64_t hash(std::string_view bytes);

}  // namespace stiefel::server
