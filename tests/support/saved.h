#pragma once

#include <vector>

#include "stiefel/simulation.h"

namespace stiefel::testing {

/// Returns the numbers of a simulation's state, as Simulation::save writes them.
inline std::vector<double> saved(const Simulation& simulation) {
  std::vector<double> out(simulation.saved_size());
  simulation.save(out);
  return out;
}

}  // namespace stiefel::testing
