#pragma once

#include "engine/motion/observables.h"
#include "stiefel/scene.h"

namespace stiefel {

/// A Simulation that reads its states through Observables. What moves them, a Map with its state,
/// is SimulationOf. Each `advance` and each `write` makes a few virtual calls; no step makes one.
class ObservedSimulation : public Simulation {
 public:
  /// Advances, and undoes a step that is stopped inside. Only a step that may take long, or a
  /// method that chooses its own steps, is stopped inside: the copy of the state that this needs
  /// costs little compared with such a step.
  RunStatus advance(std::int64_t steps, const std::stop_token& stop) final;

  void write(std::size_t index, std::span<double> out) const final {
    if (index < fields_.size())
      observables_->write(point(), index, out);
    else
      write_euler(index - fields_.size(), out);
  }
  void invariants(InvariantList& out) const final { observables_->all_invariants(point(), out); }
  std::optional<double> orthogonality() const final { return observables_->frame_defect(point()); }
  double rate() const final { return observables_->speed(point()); }
  double step_cost() const final { return step_cost_; }

  /// Moves to the first of several times, counted from step 0, without a change of `step()`; for a
  /// map that is `direct`. The others are a hint of what the next calls will ask for, so that their
  /// states can be computed together.
  RunStatus move_to(std::span<const double> times, const std::stop_token& stop);

  /// The state as a point of the Observables.
  virtual const Eigen::MatrixXd& point() const = 0;

 private:
  /// Returns what `walk` returns, and undoes a step that is stopped inside.
  template <class Walk>
  RunStatus unless_stopped_inside(const std::stop_token& stop, const Walk& walk);
  /// Writes the EulerField with this code, from the fields quaternion and angular_velocity.
  void write_euler(std::size_t code, std::span<double> out) const;

 protected:
  ObservedSimulation(const Scene& scene, SharedObservables observables);

  /// Advances while `stop` allows it.
  virtual RunStatus walk(std::int64_t steps, const std::stop_token& stop) = 0;
  virtual RunStatus walk_to(std::span<const double> times) = 0;
  /// Undoes a step that was stopped inside.
  virtual void undo() = 0;
  /// Whether the state has all substeps of length t·h.
  virtual bool has_all_substeps(double t) const = 0;

  /// Decides, once the state at step 0 is there, whether steps are stopped inside: those of a
  /// method that chooses its own steps, slow ones, and long ones.
  void stop_inside_if_long(bool chooses_steps);

  /// Whether the fields of a state that has grown far beyond the start are finite: those that are
  /// much larger than the state, which has `size` numbers, are sums of products of two of them; the
  /// others are written.
  bool fields_are_finite(Eigen::Index size) const;

  /// Names the largest step in the status of a step of the scene that left the domain, to 1e-3; to
  /// 5 % where shorter steps have none.
  RunStatus left_domain_of_all_substeps(RunStatus status, const std::stop_token& stop) const;

  SharedObservables observables_;
  int substeps_;
  double step_of_map_;  ///< |h|; 0 for a discrete system without a step
  double step_cost_;
  bool stops_inside_ = false;
  std::int64_t map_steps_ = 0;
};

}  // namespace stiefel
