#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "engine/simulation/scene.h"

namespace stiefel::server {

/// The resolved scene as bytes, the same exactly for the same scene: names, shapes and the bits of
/// every number.
std::string identity_of(const Scene& scene);

/// FNV-1a, 64 bits. Changing one byte always changes it.
std::uint64_t hash(std::string_view bytes);

}  // namespace stiefel::server
