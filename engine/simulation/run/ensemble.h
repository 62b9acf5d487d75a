#pragma once

#include "engine/simulation/run/packed_bodies.h"
#include "engine/simulation/stepping/invariant_list.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// The Simulation of an ensemble: its members at one step, each with the bits that it has alone. It
/// advances on all cores, and bodies in three dimensions side by side in vector registers. When a
/// member stops, all stop, at the last step that every one of them reached.
class Ensemble final : public Simulation {
 public:
  explicit Ensemble(const Members& scenes);
  explicit Ensemble(std::span<const Scene> scenes);

  bool direct() const override { return members_.front()->direct(); }
  std::int64_t map_steps() const override;
  RunStatus advance(std::int64_t steps, const std::stop_token& stop) override;

  std::size_t saved_size() const override { return each_saved_ * members_.size(); }
  void save(std::span<double> out) const override;
  void restore(std::int64_t step, std::span<const double> saved) override;

  void write(std::size_t index, std::span<double> out) const override;
  /// Nothing: invariants are of single members.
  void invariants(InvariantList&) const override {}
  /// The worst member's.
  std::optional<double> orthogonality() const override;
  /// The fastest member's, both.
  double rate() const override;
  std::optional<double> largest_step(double limit) const override;
  std::optional<Eigen::MatrixXd> image(const Eigen::MatrixXd&) const override {
    return std::nullopt;
  }
  std::span<const std::unique_ptr<Simulation>> members() const override {
    bring_up_to_date();
    return members_;
  }
  double step_cost() const override { return step_cost_; }

 private:
  /// Members that go together, or one that goes alone. The states of those that go together are
  /// here, as they save them, and theirs are out of date until somebody looks.
  struct Group {
    std::size_t first, count;
    std::unique_ptr<PackedBodies> packed = nullptr;
    std::vector<double> states = {}, before = {};  ///< now and before the last advance
    mutable bool stale = false;
    std::int64_t packed_steps = 0;
    /// Steps that the last advance took, and why it ended.
    std::int64_t reached = 0;
    RunStatus status = {};
  };

  template <class Scenes>
  void take(const Scenes& scenes);
  void form_group(std::span<const Scene> scenes);
  std::span<double> state(Group& group, std::size_t lane) const;
  /// Puts back what `before` or a caller kept of the group's members, at step_.
  void put_back(Group& group, std::span<const double> states);
  /// The lanes that are left over repeat the last member's.
  void fill_lanes(Group& group) const;
  void bring_up_to_date() const;
  /// Every group on its own, all at once.
  void go(std::int64_t steps, const std::stop_token& stop);
  void go_packed(Group& group, std::int64_t steps, const std::stop_token& stop);
  /// Member `index` by up to `steps`; false with the group's run status when it stopped.
  bool go_alone(Group& group, std::size_t index, std::int64_t steps, const std::stop_token& stop);
  const Simulation& fastest() const;

  std::vector<std::unique_ptr<Simulation>> members_;
  std::vector<Group> groups_;
  std::size_t each_saved_ = 0;
  double step_cost_ = 0;
};

}  // namespace stiefel
