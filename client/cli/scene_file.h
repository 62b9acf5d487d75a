#pragma once

#include <string>

#include "stiefel/v1/scene.pb.h"

namespace stiefel::cli {

/// Reads a scene in the JSON form of stiefel.v1.Scene. Throws BadInput that names the file and what
/// is wrong in it: syntax with line and column, unknown fields, fields given twice, wrong types.
v1::Scene read_scene(const std::string& path);

}  // namespace stiefel::cli
