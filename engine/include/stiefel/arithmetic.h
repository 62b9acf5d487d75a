#pragma once

namespace stiefel {

/// Selects how a map adds its increments to a state. compensated: it carries the rounding errors
/// along. plain: it does not.
enum class Arithmetic { compensated, plain };

}  // namespace stiefel
