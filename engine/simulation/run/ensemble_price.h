#pragma once

#include <cstddef>

#include "stiefel/scene.h"

namespace stiefel {

/// The price of a step of the map of so many members like `one`, in instructions: of those that go
/// together in vector registers that of their packs, as on a machine with AVX2, else `alone` for
/// each. `h_omega`: that of the fastest member, for what iterates.
double ensemble_step_price(const Scene& one, std::size_t members, double alone, double h_omega);

}  // namespace stiefel
