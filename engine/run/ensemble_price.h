#pragma once

#include <cstddef>

#include "stiefel/scene.h"

namespace stiefel {

/// Returns the price, in instructions, of a map step of `members` members like `one`. Members that
/// advance together in vector registers cost the price of their packs on a machine with AVX2; every
/// other member costs `alone`. `h_omega` is that of the fastest member and determines the number of
/// iterations.
double ensemble_step_price(const Scene& one, std::size_t members, double alone, double h_omega);

}  // namespace stiefel
