#pragma once

#include <memory>

#include "engine/simulation/catalogue.h"
#include "engine/simulation/simulation.h"

namespace stiefel {

/// A system in the catalogue: what it says of itself, and how a scene of it becomes a Simulation.
struct SystemEntry {
  SystemInfo info;
  std::unique_ptr<Simulation> (*make)(const Scene&);
};

/// One translation unit a system.
SystemEntry rigid_body_entry();
SystemEntry moser_veselov_entry();

/// The catalogue of systems. A new one is its translation unit and a line in catalogue.cc.
const std::vector<SystemEntry>& system_entries();

}  // namespace stiefel
