#pragma once

#include <string_view>

#include "engine/methods/support/method.h"

namespace stiefel {

/// The traits of a method of the catalogue; null if there is none of that name.
const MethodTraits* method_traits(std::string_view name);

/// Adds a method that systems from outside the library offer (register_system, under the same
/// conditions). What it keeps is in their SystemInfo::methods.
void register_method(const MethodTraits& traits);

}  // namespace stiefel
