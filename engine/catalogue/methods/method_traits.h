#pragma once

#include <string_view>

#include "engine/methods/support/method.h"

namespace stiefel {

/// Returns the traits of a method of the catalogue; null if there is none of that name.
const MethodTraits* method_traits(std::string_view name);

/// Adds a method that systems from outside the library offer. The conditions are those of
/// register_system. SystemInfo::methods of these systems declares what the method keeps.
void register_method(const MethodTraits& traits);

}  // namespace stiefel
