#pragma once

#include <optional>
#include <string>

#include "stiefel/price.h"

namespace stiefel {

/// Returns the price of one step of as many bodies like this one, side by side, as a register of
/// AVX2 holds, 4 in double precision and 8 in single; nullopt where the list has no entry, which is so for bodies that
/// cannot be packed.
std::optional<double> pack_price(const Scene& one);

/// Returns a warning where the list has no entry for a scene that has a method; else nullopt.
std::optional<std::string> estimate_warning(const Scene& scene);

}  // namespace stiefel
