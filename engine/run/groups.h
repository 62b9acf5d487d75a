#pragma once

#include <span>
#include <vector>

#include "engine/run/packed_bodies.h"
#include "stiefel/price.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Calls `visit` with groups of members, in their order. Consecutive members that can be packed
/// form groups of as many as a vector register has lanes; every other member is a group of its own.
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

/// Packs at most `body_lanes` bodies by their closed form. `start` holds the states at step 0 of as
/// many bodies as there are lanes. `advance` makes all steps as one.
std::unique_ptr<PackedBodies> pack_closed_forms(std::span<const Scene> bodies,
                                                std::span<const double> start);

/// Returns a rough number of nanoseconds for a step of a group, for slicing. `one` is the
/// simulation of one of its members.
inline double group_cost(std::span<const Scene> group, const Simulation& one) {
  const Scene& first = group.front();
  if (group.size() == 1) return one.step_cost();
  return first.substeps() *
         nanoseconds(ensemble_step_price(first, group.size(), step_weight(first)));
}

}  // namespace stiefel
