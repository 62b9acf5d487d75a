#pragma once

#include <optional>
#include <string_view>

#include "engine/stepping/tangent_map.h"

namespace stiefel {

/// Returns the tangents of a system of systems.inc.
std::optional<Tangents> tangents_of(std::string_view system);

}  // namespace stiefel
