#pragma once

#include <memory>

#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"

namespace stiefel {

class SceneDraft;

/// A system in the catalogue: what it says of itself, how a scene of it is checked, and how a scene
/// becomes a Simulation.
struct SystemEntry {
  SystemInfo info;
  void (*check)(SceneDraft&);
  std::unique_ptr<Simulation> (*make)(const Scene&);
};

/// One translation unit a system.
SystemEntry rigid_body_entry();
SystemEntry right_rigid_body_entry();
SystemEntry symmetric_rigid_body_entry();
SystemEntry right_symmetric_rigid_body_entry();
SystemEntry reduced_rigid_body_entry();
SystemEntry mclachlan_scovel_entry();
SystemEntry parametric_rigid_body_entry();
SystemEntry stiefel_entry();
SystemEntry stiefel_momentum_entry();
SystemEntry stiefel_costate_entry();
SystemEntry ellipsoid_entry();
SystemEntry double_bracket_entry();
SystemEntry moser_veselov_entry();
SystemEntry moser_veselov_pair_entry();
SystemEntry symmetric_moser_veselov_entry();
SystemEntry parametric_moser_veselov_entry();
SystemEntry discrete_stiefel_entry();

/// The catalogue of systems. A new one is its translation unit and a line in catalogue.cc.
const std::vector<SystemEntry>& system_entries();
/// Null if there is none of that name.
const SystemEntry* system_entry(std::string_view name);

}  // namespace stiefel
