#pragma once

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "engine/motion/packed_bodies.h"
#include "engine/numbers/parallel.h"
#include "stiefel/price.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Calls visit(scenes, first) with groups of the members begin ... end - 1, in their order, where
/// `first` is the index of the group's first member. Consecutive members that can be packed form
/// groups of as many as a vector register has lanes; every other member is a group of its own.
template <class Visit>
void for_each_group(const Members& members, std::size_t begin, std::size_t end,
                    const Visit& visit) {
  std::vector<Scene> together;
  const auto flush = [&](std::size_t after) {
    const std::size_t count = together.size();
    if (count > 0) visit(std::exchange(together, {}), after - count);
  };
  for (std::size_t b = begin; b < end; ++b) {
    stop_point();
    Scene scene = members[b];
    const bool packed = can_be_packed(scene);
    if (!packed) flush(b);
    together.push_back(std::move(scene));
    if (!packed || together.size() == static_cast<std::size_t>(body_lanes(together.front())))
      flush(b + 1);
  }
  flush(end);
}

/// Returns what make(scenes, first) returns for all groups of the members, in their order. Portions
/// of the members are made on the threads of the crew.
template <class Make>
auto groups_of(const Members& members, const Make& make) {
  constexpr std::size_t portion = 64;  // a multiple of the lanes of every register
  constexpr double of_member = 4000;   // nanoseconds of a small one
  using Groups = std::vector<decltype(make(std::vector<Scene>(), std::size_t{}))>;
  std::vector<Groups> portions((members.size() + portion - 1) / portion);
  for_each_in_parallel(
      std::span(portions), of_member * static_cast<double>(members.size()), [&](Groups& groups) {
        const auto begin = portion * static_cast<std::size_t>(&groups - portions.data());
        for_each_group(members, begin, std::min(members.size(), begin + portion),
                       [&](std::vector<Scene> together, std::size_t first) {
                         groups.push_back(make(std::move(together), first));
                       });
      });
  Groups all;
  for (Groups& groups : portions) std::ranges::move(groups, std::back_inserter(all));
  return all;
}

/// Returns a rough number of nanoseconds for a step of a group, for slicing. `one` is the
/// simulation of one of its members.
inline double group_cost(std::span<const Scene> group, const Simulation& one) {
  const Scene& first = group.front();
  if (group.size() == 1) return one.step_cost();
  return first.substeps() *
         nanoseconds(ensemble_step_price(first, group.size(), step_weight(first)));
}

}  // namespace stiefel
