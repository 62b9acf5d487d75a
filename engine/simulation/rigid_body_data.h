#pragma once

#include "engine/simulation/catalogue.h"

namespace stiefel {

/// What rigid_body and moser_veselov have in common: blocks, fields and invariants of (Q, M).
SystemInfo rigid_body_family();

/// `kept(invariant)` for each of the family's invariants.
template <class KeptOf>
std::vector<Preservation> preservations(KeptOf kept) {
  std::vector<Preservation> all;
  for (const auto& invariant : rigid_body_family().invariants)
    all.push_back({invariant.name, kept(invariant.name)});
  return all;
}

}  // namespace stiefel
