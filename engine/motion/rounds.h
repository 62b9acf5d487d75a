#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "engine/numbers/parallel.h"

namespace stiefel {

/// How the groups of members of an ensemble move in slices of work. A round takes all groups to one
/// step, a part of them in each slice, so that a group that was fetched from memory takes many
/// steps before it makes room for the others.
///
/// A slice is given as the number of steps that all groups could take in it on one thread; a
/// fraction stands for less than a step.
class Rounds {
 public:
  /// The groups of a part for each thread: enough that few threads wait for the last one.
  static constexpr double part = 16;

  /// Returns the most steps of a round, at least 1.
  static double steps(std::size_t groups, double slice) {
    return std::max(1.0, slice * std::max(1.0, static_cast<double>(groups) / part));
  }

  /// Whether all groups are at one step.
  bool aligned() const { return passed_ == 0; }
  /// The number of groups that are at the end of the round, if it is under way.
  std::size_t passed() const { return passed_; }

  /// Returns the groups that go next, for a round of `steps`.
  template <class Group>
  std::span<Group> next(std::span<Group> groups, double steps, double slice) const {
    const std::size_t left = groups.size() - passed_;
    return groups.subspan(passed_,
                          slice >= steps ? left : width(groups.size(), left, slice / steps));
  }
  /// Notes that the next `moved` of the groups are at the end of the round.
  void pass(std::size_t moved, std::size_t groups) {
    passed_ += moved;
    if (passed_ == groups) passed_ = 0;
  }
  /// Gives the round up: its groups must have gone back.
  void give_up() { passed_ = 0; }

 private:
  /// Returns the size of the next of equal parts of the groups that are left, where a thread moves
  /// that share of all groups in a slice.
  static std::size_t width(std::size_t groups, std::size_t left, double share) {
    Crew* crew = crew_to_divide();
    const double threads = crew ? static_cast<double>(crew->threads_at_hand()) : 1;
    const double most = std::max(1.0, share * threads * static_cast<double>(groups));
    const double of_left = static_cast<double>(left);
    return static_cast<std::size_t>(std::ceil(of_left / std::ceil(of_left / most)));
  }

  std::size_t passed_ = 0;
};

}  // namespace stiefel
