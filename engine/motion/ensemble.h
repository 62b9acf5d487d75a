#pragma once

#include "engine/motion/invariant_list.h"
#include "engine/motion/packed_bodies.h"
#include "engine/motion/rounds.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// The Simulation of an ensemble: all its members at one step, each with the bits that it has
/// alone. It advances on all cores, and bodies in three or four dimensions side by side in vector
/// registers; in slices by Rounds. When a member stops, all members stop at the last step that
/// every one of them reached.
class Ensemble final : public Simulation {
 public:
  explicit Ensemble(const Members& scenes);
  /// Takes members that form one group (for_each_group).
  explicit Ensemble(std::span<const Scene> group);

  bool direct() const override { return members_.front()->direct(); }
  std::int64_t map_steps() const override;
  RunStatus advance(std::int64_t steps, const std::stop_token& stop) override;
  std::optional<RunStatus> advance_slice(std::int64_t steps, double slice,
                                         const std::stop_token& stop) override;
  void turn_back() override;

  std::size_t saved_size() const override { return each_saved_ * members_.size(); }
  void save(std::span<double> out) const override;
  void restore(std::int64_t step, std::span<const double> saved) override;

  void write(std::size_t index, std::span<double> out) const override;
  /// Adds nothing, because only single members have invariants.
  void invariants(InvariantList&) const override {}
  /// Returns the value of the worst member.
  std::optional<double> orthogonality() const override;
  /// `rate` and `largest_step` return the values of the fastest member.
  double rate() const override;
  std::optional<double> largest_step(double limit) const override;
  std::optional<Eigen::MatrixXd> image(const Eigen::MatrixXd&) const override {
    return std::nullopt;
  }
  std::span<const std::unique_ptr<Simulation>> members() const override {
    for (const Group& group : groups_) bring_up_to_date(group);
    return members_;
  }
  double step_cost() const override { return step_cost_; }

 private:
  /// Members that advance together in vector registers, or one that advances alone. For members
  /// that advance together `states` holds what their simulations would save; the simulations
  /// themselves are out of date (`stale`) until `bring_up_to_date`.
  struct Group {
    std::size_t first, count;
    bool can_be_packed;
    std::unique_ptr<PackedBodies> packed = nullptr;
    std::vector<double> states = {}, before = {};  ///< states now, and before the last round
    mutable bool stale = false;
    std::int64_t packed_steps = 0;
    /// Number of steps of the last round, and why it ended.
    std::int64_t reached = 0;
    RunStatus status = {};
  };

  struct Round {
    std::int64_t steps;
    RunStatus status = {};  ///< with which it ends
    bool again = false;     ///< whether a member stopped after `steps`
  };

  /// Sets what follows from the groups; takes the first member.
  void sum_up(const Scene& first);
  Group form_group(std::span<const Scene> scenes, std::size_t first);
  std::span<double> state(Group& group, std::size_t lane) const;
  /// Sets the states of the group's members at step_, from `before` or from a caller.
  void put_back(Group& group, std::span<const double> states);
  /// Copies the last member's state to the lanes that have no member.
  void fill_lanes(Group& group) const;
  /// Sets the simulations of the group's members to its states.
  void bring_up_to_date(const Group& group) const;
  /// Advances these groups independently, in parallel, to the end of the round.
  void go(std::span<Group> groups, const std::stop_token& stop);
  void give_up_round();
  void go_packed(Group& group, std::int64_t steps, const std::stop_token& stop);
  /// Advances member `index` by up to `steps`. Returns false, and sets the group's run status, when
  /// the member stopped.
  bool go_alone(Group& group, std::size_t index, std::int64_t steps, const std::stop_token& stop);
  const Simulation& fastest() const;

  std::vector<std::unique_ptr<Simulation>> members_;
  std::vector<Group> groups_;
  std::size_t each_saved_ = 0;
  double step_cost_ = 0;
  Rounds rounds_;
  std::optional<Round> round_;  ///< that is under way
};

}  // namespace stiefel
