#pragma once

#include <span>
#include <vector>

#include "engine/simulation/run/packed_bodies.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Gives the members of an ensemble to `visit` in their order, as they go together: as many in a
/// row as a vector register has lanes of those that can be packed, the others alone.
template <class Scenes, class Visit>
void for_each_group(const Scenes& scenes, const Visit& visit) {
  std::vector<Scene> together;
  const auto flush = [&] {
    if (!together.empty()) visit(std::span<const Scene>(together));
    together.clear();
  };
  for (const Scene& scene : scenes) {
    stop_point();
    if (!can_be_packed(scene)) {
      flush();
      visit(std::span(&scene, 1));
      continue;
    }
    together.push_back(scene);
    if (together.size() == static_cast<std::size_t>(body_lanes(scene))) flush();
  }
  flush();
}

/// Nanoseconds of a step of a group, roughly and on all cores, for slicing; `one`: the simulation
/// of one of its members.
inline double group_cost(std::span<const Scene> group, const Simulation& one) {
  constexpr double packed = 5;  // of one body
  if (group.size() == 1) return one.step_cost();
  return packed * group.front().substeps() * static_cast<double>(group.size());
}

}  // namespace stiefel
