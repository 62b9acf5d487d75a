#pragma once

#include "engine/motion/invariant_list.h"
#include "engine/motion/joint_motion.h"
#include "engine/motion/rounds.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// The Simulation of an ensemble: all its members at one step, each with the bits that it has
/// alone. It advances on all cores, and bodies in three or four dimensions side by side in vector
/// registers; in slices by Rounds. When a member stops, all members stop at the last step that
/// every one of them reached.
class Ensemble final : public Simulation {
 public:
  explicit Ensemble(const Scene& ensemble);

  /// The members as numbers, to be shared; may be null.
  const std::shared_ptr<const FlatBodies>& flat() const { return motion_.flat(); }

  bool direct() const override { return motion_.first().direct(); }
  std::int64_t map_steps() const override { return motion_.map_steps(); }
  RunStatus advance(std::int64_t steps, const std::stop_token& stop) override;
  std::optional<RunStatus> advance_slice(std::int64_t steps, double slice,
                                         const std::stop_token& stop) override;
  void turn_back() override;

  std::size_t saved_size() const override { return motion_.each_saved() * motion_.size(); }
  void save(std::span<double> out) const override;
  void restore(std::int64_t step, std::span<const double> saved) override;

  void write(std::size_t index, std::span<double> out) const override;
  /// Adds nothing, because only single members have invariants.
  void invariants(InvariantList&) const override {}
  /// Returns the value of the worst member.
  std::optional<double> orthogonality() const override;
  /// `rate` and `largest_step` return the values of the fastest member.
  double rate() const override { return rate(fastest()); }
  double rate(std::size_t member) const { return motion_.read(member).rate(); }
  std::optional<double> largest_step(double limit) const override {
    return motion_.simulation(fastest()).largest_step(limit);
  }
  std::optional<Eigen::MatrixXd> image(const Eigen::MatrixXd&) const override {
    return std::nullopt;
  }
  std::span<const std::unique_ptr<Simulation>> members() const override {
    return motion_.simulations();
  }
  double step_cost() const override { return step_cost_; }

 private:
  struct Round {
    std::int64_t steps;
    RunStatus status = {};  ///< with which it ends
    bool again = false;     ///< whether a member stopped after `steps`
  };

  /// Advances these groups independently, in parallel, to the end of the round.
  void go(std::span<JointMotion::Group> groups, const std::stop_token& stop);
  void give_up_round();
  std::size_t fastest() const;

  const Scene scene_;
  JointMotion motion_;
  std::vector<JointMotion::Reached> reached_;  ///< of each group, in the last round
  double step_cost_;
  Rounds rounds_;
  std::optional<Round> round_;  ///< that is under way
};

}  // namespace stiefel
