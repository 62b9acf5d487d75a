#pragma once

#include <string_view>

/// The families of invariants by their names in files, requests and replies.
namespace stiefel::family {

inline constexpr std::string_view energy = "energy";
inline constexpr std::string_view hamiltonian = "hamiltonian";
inline constexpr std::string_view discrete_hamiltonian = "discrete_hamiltonian";
inline constexpr std::string_view spatial_momentum = "spatial_momentum";
inline constexpr std::string_view casimirs = "casimirs";
inline constexpr std::string_view manakov = "manakov";
inline constexpr std::string_view lax = "lax";
inline constexpr std::string_view joachimsthal = "joachimsthal";
inline constexpr std::string_view singular_values = "singular_values";
inline constexpr std::string_view PQt = "PQt";
inline constexpr std::string_view PQ_inverse = "PQ_inverse";
inline constexpr std::string_view orthogonality = "orthogonality";

}  // namespace stiefel::family
