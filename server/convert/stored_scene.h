#pragma once

#include <expected>
#include <string>

#include "stiefel/scene.h"

namespace stiefel::server {

/// Returns a resolved scene as the bytes of a stiefel.v1.Scene, which keeps every bit.
std::string to_bytes(const Scene& scene);

/// Returns the scene of such bytes, or why this build cannot resolve it.
std::expected<Scene, std::string> scene_of(const std::string& bytes);

}  // namespace stiefel::server
