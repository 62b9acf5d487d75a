#pragma once

#include <string_view>

/// The families of invariants by their names in files, requests and replies.
namespace stiefel::family {

inline constexpr std::string_view energy = "energy", hamiltonian = "hamiltonian",
                                  discrete_hamiltonian = "discrete_hamiltonian",
                                  spatial_momentum = "spatial_momentum", casimirs = "casimirs",
                                  manakov = "manakov", lax = "lax", joachimsthal = "joachimsthal",
                                  singular_values = "singular_values", PQt = "PQt",
                                  PQ_inverse = "PQ_inverse", orthogonality = "orthogonality";

}  // namespace stiefel::family
