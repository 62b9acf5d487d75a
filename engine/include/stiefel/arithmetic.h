#pragma once

namespace stiefel {

/// How a map sums what it adds to a state in every step: with what rounding took away carried along
/// (compensated), or without (plain).
enum class Arithmetic { compensated, plain };

}  // namespace stiefel
