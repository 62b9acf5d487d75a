#pragma once

/// The names of methods that others ask for, so that a change of a method compiles its steps alone.
namespace stiefel::method_name {

inline constexpr const char *exact = "exact", *preprocessed = "preprocessed_variational",
                            *rk4 = "rk4", *variational = "variational";

}  // namespace stiefel::method_name
