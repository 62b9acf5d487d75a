#pragma once

namespace stiefel {

/// How a map adds its increments to a state: with the rounding errors carried along (compensated),
/// or without (plain).
enum class Arithmetic { compensated, plain };

}  // namespace stiefel
