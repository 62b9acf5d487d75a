#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "stiefel/simulation.h"

namespace stiefel {

/// What a simulation of a scene offers: its fields and sizes.
struct Outline {
  std::vector<Field> fields;
  std::size_t block_count = 0, saved_size = 0;
  double step_cost = 0;  ///< Simulation::step_cost
  bool direct = false;
};

/// Returns the indices of the fields that are reported where none are named: the variables in which
/// the scene is given. These are `quaternion` and `angular_velocity` for a scene with `body`,
/// otherwise the system's blocks, the first `block_count` of the fields that it offers.
std::vector<std::size_t> default_fields(const Scene& scene, const std::vector<Field>& offered,
                                        std::size_t block_count);

Outline outline_of(const Simulation& simulation);

/// Returns the outline of an ensemble without building its simulation: makes the members'
/// simulations one after another, calls `look` with each and its scene, and drops it.
Outline outline_of(const Members& members,
                   const std::function<void(const Scene&, const Simulation&)>& look);

}  // namespace stiefel
