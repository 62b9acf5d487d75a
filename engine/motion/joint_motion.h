#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engine/motion/flat_bodies.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// The motion of some members of an ensemble, or of one scene that is no ensemble, in groups that
/// advance independently: bodies side by side in vector registers, or one member. Below, i counts
/// the members of this object. The simulation of a body that advances with others is made when it
/// is asked for, and lives until its group advances.
class JointMotion {
 public:
  struct Group {
    std::span<std::size_t> members;  ///< i of each
    std::shared_ptr<const PackedBodies> packed = nullptr;
    std::int64_t step = 0;
    /// For packed bodies: the states now, lane by lane, and before the last `advance`. For a member
    /// alone: what `keep` kept.
    std::span<double> states = {}, before = {};
    std::int64_t map_steps = 0;
  };
  /// The number of steps that all members of a group have made, and why one of them, i = `member`,
  /// made no more.
  struct Reached {
    std::int64_t steps = 0;
    RunStatus status = {};
    std::size_t member = 0;
  };

  /// Takes `count` members of an ensemble from `first` on, or a scene alone; the scene must outlive
  /// this object. `flat` is flat_bodies(scene); `made`, if given, simulates the first at step 0.
  JointMotion(const Scene& scene, std::shared_ptr<const FlatBodies> flat, std::size_t first,
              std::size_t count, std::unique_ptr<Simulation> made = nullptr);

  std::size_t size() const { return members_.size(); }
  /// Returns the index in the ensemble.
  std::size_t index(std::size_t i) const { return members_[i]; }
  std::span<Group> groups() { return groups_; }
  std::span<const Group> groups() const { return groups_; }
  /// The simulation of one member, for what does not depend on the state.
  const Simulation& first() const { return flat_ ? flat_->first() : *simulations_.front(); }
  const std::shared_ptr<const FlatBodies>& flat() const { return flat_; }
  std::size_t each_saved() const { return each_saved_; }
  /// Whether member i advances with others in vector registers, and how many do.
  bool is_packed(std::size_t i) const { return groups_[place_[i].group].packed != nullptr; }
  std::size_t packed() const;
  /// Returns the sum of Simulation::map_steps.
  std::int64_t map_steps() const;

  /// Advances a group by up to `steps`, until one of its members stops.
  Reached advance(Group& group, std::int64_t steps, const std::stop_token& stop);

  // A group is at one step, at first step 0.

  std::int64_t step(std::size_t i) const { return groups_[place_[i].group].step; }
  void save(std::size_t i, std::span<double> out) const;
  /// Restores member i; the other members of its group must be restored too.
  void restore(std::size_t i, std::int64_t step, std::span<const double> saved);
  /// Keeps the state of a group for `turn_back`; that of a pack is kept by `advance`.
  void keep(Group& group) const;
  /// Sets a group back to the state that was kept, of `step`.
  void turn_back(Group& group, std::int64_t step);

  /// Returns the simulation of member i in its state, or those of all.
  Simulation& simulation(std::size_t i) const;
  std::span<const std::unique_ptr<Simulation>> simulations() const;
  /// Returns what reads the state of member i, or a saved state of it, until the next call.
  const Simulation& read(std::size_t i) const;
  const Simulation& read(std::size_t i, std::int64_t step, std::span<const double> saved) const;
  /// Writes a field of the members of a group into that of all members, which has `each` numbers
  /// for one.
  void write(const Group& group, std::size_t index, std::size_t each, std::span<double> out) const;

  /// Takes a member out of its group, which goes on without it.
  void leave(Group& group, std::size_t i);
  /// Goes on with those members that `stays`, called with their indices in the ensemble, selects.
  /// All must be at one step. Forms new groups.
  void keep_members(const std::function<bool(std::size_t index)>& stays);

 private:
  struct Place {
    std::size_t group, lane;
  };

  Scene scene(std::size_t i) const;
  void drop_simulation(std::size_t i);
  /// Forms groups of the members.
  void form_groups();
  /// Packs the members of a group, in the states of step 0.
  void pack(Group& group) const;
  /// Copies the last member's state to the lanes that have no member.
  void fill_lanes(Group& group) const;
  std::span<double> lane(Group& group, std::size_t k) const {
    return group.states.subspan(each_saved_ * k, each_saved_);
  }
  std::span<const double> state(std::size_t i) const {
    return groups_[place_[i].group].states.subspan(each_saved_ * place_[i].lane, each_saved_);
  }
  /// Sets `torn` if some members of the group are a step further than the others.
  Reached advance_packed(Group& group, std::int64_t steps, const std::stop_token& stop, bool& torn);

  const Scene& scene_;
  std::shared_ptr<const FlatBodies> flat_;
  std::vector<std::size_t> members_;
  mutable std::vector<std::unique_ptr<Simulation>> simulations_;
  mutable std::unique_ptr<FlatReader> reader_;
  mutable std::unique_ptr<Simulation> other_;  ///< that `read` returned last
  std::vector<Group> groups_;
  std::vector<std::size_t> grouped_;   ///< Group::members of one group after another
  std::unique_ptr<double[]> numbers_;  ///< the groups' states, uninitialized until they are written
  std::vector<Place> place_;           ///< of each member
  std::size_t each_saved_ = 0;
  std::int64_t map_steps_before_ = 0;  ///< of members and groups that are gone
};

}  // namespace stiefel
