#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// The simulation of those members of a group that have not ended, or of one scene that is no
/// ensemble. The members have indices in the group; the i-th of those that are left has the index
/// `going()[i]`.
class JointSimulation {
 public:
  /// `scenes`, those of all members of the group, must outlive this object.
  JointSimulation(std::span<const Scene> scenes, bool ensemble);

  bool direct() const { return direct_; }
  /// Returns how many numbers Simulation::save gives for one member.
  std::size_t each_saved() const { return each_saved_; }
  std::size_t saved_size() const { return each_saved_ * going_.size(); }

  const std::vector<std::size_t>& going() const { return going_; }
  std::int64_t step() const { return step_; }
  /// Returns the number of steps of all members together.
  std::int64_t computed_steps() const { return computed_; }
  /// Returns the sum of Simulation::map_steps over all members.
  std::int64_t map_steps() const { return map_steps_; }
  /// Returns the state of the i-th member that is left.
  const Simulation& state(std::size_t i) const;

  RunStatus advance(std::int64_t to, const std::stop_token& stop);
  /// Saves or restores the states of the members that are left, one after another.
  void save(std::span<double> out) const;
  void restore(std::int64_t step, std::span<const double> saved);
  /// Goes on with the members `going` only, from their saved states.
  void resume(std::vector<std::size_t> going, std::int64_t step, std::span<const double> saved);

  /// Removes the members, given by index in the group, that have ended.
  void remove(const std::function<bool(std::size_t)>& ended);
  void remove_all() { going_.clear(); }

 private:
  /// Replaces the simulation by one of the members that are left, or by none if there are none.
  void rebuild();

  std::span<const Scene> scenes_;
  bool ensemble_;
  std::vector<std::size_t> going_;
  std::vector<Scene> remaining_;  ///< scenes of the members in going_, once a member has left
  std::unique_ptr<Simulation> simulation_;
  bool direct_;
  std::size_t each_saved_;
  std::int64_t step_ = 0, computed_ = 0, map_steps_ = 0;
};

}  // namespace stiefel
