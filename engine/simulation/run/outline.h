#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "stiefel/simulation.h"

namespace stiefel {

/// What a simulation of a scene offers.
struct Outline {
  std::vector<Field> fields;
  std::size_t block_count = 0, saved_size = 0;
  double step_cost = 0;  ///< Simulation::step_cost
  bool direct = false;
};

Outline outline_of(const Simulation& simulation);

/// That of an ensemble, without its simulation: those of the members are made one after another,
/// for `look` at each, and dropped.
Outline outline_of(const Members& members, const std::function<void(const Simulation&)>& look);

}  // namespace stiefel
