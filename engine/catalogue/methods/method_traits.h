#pragma once

#include <string_view>

#include "engine/methods/support/method.h"

namespace stiefel {

/// Returns the traits of a method of the catalogue; null if there is none of that name.
const MethodTraits* method_traits(std::string_view name);

}  // namespace stiefel
