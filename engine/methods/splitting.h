#pragma once

#include "engine/methods/method.h"

namespace stiefel {

/// The rigid body in three dimensions by splitting its energy ½ Σ m_i²/I_i. Each term alone turns m
/// and Q about a principal axis at the constant rate m_i/I_i. Strang's composition of the flows of
/// the three terms is symmetric, explicit and of order 2:
///
///     Φ_h = φ¹_{h/2} ∘ φ²_{h/2} ∘ φ³_h ∘ φ²_{h/2} ∘ φ¹_{h/2}.
///
/// The map is Poisson: it keeps the spatial momentum, |m| and the orthogonality of Q to rounding,
/// and the energy error stays bounded.
struct Splitting {
  static constexpr MethodTraits traits = {
      .name = "splitting",
      .summary = "Strang composition of rotations about the principal axes, N = 3",
      .source = "McLachlan 1993; Touma and Wisdom 1994; Reich 1994",
      .file = "engine/methods/splitting.h",
      .orders = {2},
      .default_order = 2,
      .reversible = true,
  };

  static constexpr Conservation conservation(const SystemTraits& system,
                                             std::string_view invariant) {
    return system.conserved_on_orbits(invariant) ? Conservation::exact : Conservation::bounded;
  }
};

}  // namespace stiefel
