#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "engine/methods/concepts.h"
#include "engine/motion/coordinates.h"
#include "engine/motion/observed_simulation.h"
#include "engine/numbers/parallel.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The Simulation that iterates a Map.
template <class F>
requires Map<F>
class SimulationOf final : public ObservedSimulation {
 public:
  /// Returns the map of a step t·h, where h is the step of the simulation's map.
  using Make = std::function<F(double t)>;

  /// With `make`, the largest step in the status of a step that left the domain is that of all
  /// substeps; without, the map's.
  [[gnu::cold]] SimulationOf(const Scene& scene, F map, SharedObservables observables,
                             Make make = nullptr)
      : ObservedSimulation(scene, std::move(observables)),
        map_(std::move(map)),
        make_(std::move(make)),
        point_(observables_->start),
        state_(map_.start(Converted::of(point_))) {
    if constexpr (is_point) point_.resize(0, 0);
    stop_inside_if_long(requires(F f) { f.attempts(); });
    bool may_change_first = stops_inside_;
    if constexpr (requires { map_.stops_before_change(); })
      may_change_first = stops_inside_ && !map_.stops_before_change();
    copies_each_step_ = !DirectMap<F> && (substeps_ > 1 || may_change_first);
    usual_ = std::min(usual_growth * squared_norm(), std::numeric_limits<double>::max() / 4);
    state_.each([this](auto& block) { saved_size_ += static_cast<std::size_t>(block.size()); });
  }

  bool direct() const override { return DirectMap<F>; }

  std::int64_t map_steps() const override {
    if constexpr (requires { map_.attempts(); })
      return map_.attempts();
    else
      return map_steps_;
  }

  std::size_t saved_size() const override { return saved_size_; }

  void save(std::span<double> out) const override {
    double* to = out.data();
    state_.each([&](auto& block) {
      copy_numbers(block.data(), block.size(), to);
      to += block.size();
    });
  }

  void restore(std::int64_t step, std::span<const double> saved) override {
    const double* from = saved.data();
    state_.each([&](auto& block) {
      copy_numbers(from, block.size(), block.data());
      from += block.size();
    });
    step_ = step;
    since_copy_ = between_copies;
  }

  [[gnu::cold]] std::optional<double> largest_step(double limit) const override {
    return map_.largest_step(state_, limit);
  }

  [[gnu::cold]] std::optional<Eigen::MatrixXd> image(const Eigen::MatrixXd& blocks) const override {
    Eigen::MatrixXd x = observables_->from_blocks(blocks);
    auto state = map_.start(Converted::of(x));
    if (!map_.step(state).reached() || !state.x.value.allFinite()) return std::nullopt;
    Converted::write(state.x.value, x);
    return observables_->to_blocks(x);
  }

 private:
  using Point = typename F::Point;
  using Converted = Coordinates<Point>;
  static constexpr bool is_point = std::is_same_v<Point, Eigen::MatrixXd>;
  /// Whether the map moves every block by rotations, so that it stays as large as it is.
  static constexpr bool only_rotates = requires { requires F::only_rotates; };
  /// Number of steps between two copies of the state, from which a step that ends in a state that
  /// is not finite is undone.
  static constexpr int between_copies = 64;
  /// The fields of a state are finite while |x|² is at most so many times that of the start.
  static constexpr double usual_growth = 0x1p40;

  const Eigen::MatrixXd& point() const override {
    if constexpr (is_point) {
      return state_.x.value;
    } else {
      Converted::write(state_.x.value, point_);
      return point_;
    }
  }

  RunStatus walk(std::int64_t steps, const std::stop_token& stop) override {
    if constexpr (DirectMap<F>) {
      if (steps == 0) return {};
      const std::int64_t to = step_ + steps;
      ++map_steps_;
      const Outcome outcome = map_.at(state_, static_cast<long double>(to) * substeps_);
      if (outcome == Outcome::reached) step_ = to;
      return {outcome, std::nullopt};
    } else {
      for (const std::int64_t end = step_ + steps; step_ < end; ++step_) {
        if (copies_each_step_ || (!only_rotates && since_copy_ >= between_copies)) {
          before_.resize(saved_size_);
          save(before_);
          since_copy_ = 0;
        }
        if (const RunStatus status = step_of_scene(stop); !status.reached()) return status;
        if (only_rotates) continue;
        if (!(squared_norm() <= usual_) && !is_finite()) return go_back();
        ++since_copy_;
      }
      return {};
    }
  }

  /// Goes back to the copy, and from there to the state before the last step.
  RunStatus go_back() {
    const std::int64_t good = since_copy_;
    restore(step_ - good, before_);
    walk(good, {});
    return {Outcome::not_finite, std::nullopt};
  }

  RunStatus step_of_scene(const std::stop_token& stop) {
    for (int k = 0; k < substeps_; ++k) {
      const RunStatus status = step_of_map(stop);
      if (status.reached()) continue;
      if (k > 0) undo();
      return status.outcome == Outcome::left_domain && make_
                 ? left_domain_of_all_substeps(status, stop)
                 : status;
    }
    return {};
  }

  RunStatus step_of_map(const std::stop_token& stop) {
    if (stop.stop_requested()) return {Outcome::cancelled, std::nullopt};
    ++map_steps_;
    if constexpr (requires { map_.step(state_, stop); })
      return map_.step(state_, stop);
    else
      return map_.step(state_);
  }

  void undo() override {
    if (copies_each_step_) restore(step_, before_);
  }

  RunStatus walk_to(std::span<const double> times) override {
    if constexpr (DirectMap<F>) {
      ++map_steps_;
      return {map_.at(state_, times), std::nullopt};
    } else {
      throw std::logic_error("this map goes to steps alone");
    }
  }

  /// Returns |x|², or what the map keeps that grows with it.
  double squared_norm() const {
    if constexpr (requires { state_.squared_norm(); })
      return static_cast<double>(state_.squared_norm());
    else
      return static_cast<double>(state_.x.value.squaredNorm());
  }

  [[gnu::noinline]] bool is_finite() const {
    const StopScope whole = StopScope::nothing();  // the step is made
    return std::isfinite(squared_norm()) && fields_are_finite(state_.x.value.size());
  }

  [[gnu::cold]] bool has_all_substeps(double t) const override {
    F map = make_(t);
    auto trial = map.start(state_.x.value);
    for (int k = 0; k < substeps_; ++k) {
      stop_point();
      if (!has_step(map, trial)) return false;
    }
    return true;
  }
  static bool has_step(F& map, typename F::State& state) {
    if constexpr (requires { map.run(state); })
      return map.run(state).reached();
    else
      return map.step(state).reached();
  }

  mutable F map_;  // mutable only for its workspace
  Make make_;
  mutable Eigen::MatrixXd point_;    ///< what `point` returns where the state is not a point itself
  mutable typename F::State state_;  // mutable because `each` serves both saving and restoring
  std::vector<double> before_;       ///< the state since_copy_ steps before, as `save` writes it
  int since_copy_ = between_copies;
  std::size_t saved_size_ = 0;
  /// Whether a step may fail or be stopped when the state has changed already.
  bool copies_each_step_ = false;
  double usual_ = 0;  ///< |x|² up to which every field is finite
};

}  // namespace stiefel
