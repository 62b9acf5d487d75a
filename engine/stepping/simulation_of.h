#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "engine/linalg/iteration/continuation.h"
#include "engine/methods/support/map.h"
#include "engine/stepping/invariant_list.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The Simulation of a Map whose states `Observables` can read. One virtual call covers many steps;
/// no step makes a virtual call itself.
template <class F, class Observables>
requires Map<F>
class SimulationOf final : public Simulation {
 public:
  /// Returns the map of a step t·h, where h is the step of the simulation's map.
  using Make = std::function<F(double t)>;

  /// `step_cost` is the number of nanoseconds for a step of the map. With `make`, the largest step
  /// in the status of a step that left the domain is that of all substeps; without, the map's.
  SimulationOf(const Scene& scene, F map, Observables observables, double step_cost,
               Make make = nullptr)
      : map_(std::move(map)),
        make_(std::move(make)),
        observables_(std::move(observables)),
        substeps_(scene.substeps()),
        step_of_map_(std::abs(scene.description().step.value_or(0)) / substeps_),
        step_cost_(step_cost * substeps_),
        state_(map_.start(observables_.start(scene))),
        before_(state_) {
    stops_inside_ = step_cost >= slow_step || chooses_steps || has_long_steps();
    fields_ = observables_.fields();
    block_count_ = observables_.block_count();
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

  /// Advances, and undoes a step that is stopped inside. Only a step that may take long, or a
  /// method that chooses its own steps, is stopped inside: the copy of the state that this needs
  /// costs little compared with such a step.
  RunStatus advance(std::int64_t steps, const std::stop_token& stop) override {
    if (!stops_inside_) {
      const StopScope whole_steps = StopScope::nothing();
      return walk(steps, stop);
    }
    try {
      const StopScope scope(stop);
      return walk(steps, stop);
    } catch (const Stopped&) {
      state_ = before_;
      return {Outcome::cancelled, std::nullopt};
    }
  }
  std::size_t saved_size() const override { return saved_size_; }

  void save(std::span<double> out) const override {
    double* to = out.data();
    state_.each([&](auto& block) { to = std::copy_n(block.data(), block.size(), to); });
  }

  void restore(std::int64_t step, std::span<const double> saved) override {
    const double* from = saved.data();
    state_.each([&](auto& block) {
      std::copy_n(from, block.size(), block.data());
      from += block.size();
    });
    step_ = step;
    since_copy_ = between_copies;
  }

  void write(std::size_t index, std::span<double> out) const override {
    observables_.write(state_.x.value, index, out);
  }
  void invariants(InvariantList& out) const override {
    observables_.invariants(state_.x.value, out);
  }
  std::optional<double> orthogonality() const override {
    return observables_.orthogonality(state_.x.value);
  }
  double rate() const override { return observables_.rate(state_.x.value); }
  std::optional<double> largest_step(double limit) const override {
    return map_.largest_step(state_, limit);
  }
  std::optional<Eigen::MatrixXd> image([[maybe_unused]] const Eigen::MatrixXd& x) const override {
    if constexpr (std::is_same_v<typename Observables::Point, Eigen::MatrixXd>) {
      auto state = map_.start(x);
      if (map_.step(state).reached() && state.x.value.allFinite()) return state.x.value;
    } else if constexpr (requires { observables_.stacked(observables_.point(x)); }) {
      auto state = map_.start(observables_.point(x));
      if (map_.step(state).reached() && state.x.value.allFinite())
        return observables_.stacked(state.x.value);
    }
    return std::nullopt;
  }
  double step_cost() const override { return step_cost_; }

 private:
  /// Steps that take at least so many nanoseconds (5 million instructions) are slow.
  static constexpr double slow_step = 1e6;
  static constexpr bool chooses_steps = requires(F map) { map.attempts(); };
  /// Whether the map moves every block by rotations, so that it stays as large as it is.
  static constexpr bool only_rotates = requires { requires F::only_rotates; };
  /// Number of steps between two copies of the state, from which a step that ends in a state that
  /// is not finite is undone.
  static constexpr int between_copies = 64;
  /// The fields of a state are finite while |x|² is at most so many times that of the start.
  static constexpr double usual_growth = 0x1p40;

  /// Whether h‖Ω‖ > 1 at the start. An implicit method may then have to follow the solution of a
  /// step from h = 0, which takes seconds where h‖Ω‖ is a billion.
  bool has_long_steps() const { return step_of_map_ * rate() > 1; }

  RunStatus walk(std::int64_t steps, const std::stop_token& stop) {
    if constexpr (DirectMap<F>) {
      if (steps == 0) return {};
      if (stops_inside_) before_ = state_;
      const auto to = static_cast<long double>(step_ + steps) * substeps_;
      const RunStatus status = map_.at(state_, to);
      ++map_steps_;
      if (status.reached()) step_ += steps;
      return status;
    }
    bool undoing = false;
    for (; steps > 0; --steps) {
      if (substeps_ > 1 || stops_inside_ || (!only_rotates && since_copy_ >= between_copies)) {
        before_ = state_;
        since_copy_ = 0;
      }
      for (int k = 0; k < substeps_; ++k) {
        const RunStatus status = step_of_map(stop, only_rotates || !undoing);
        if (status.reached()) continue;
        if (k > 0) state_ = before_;
        return status.outcome == Outcome::left_domain ? left_domain(status, stop) : status;
      }
      if (!only_rotates && !(squared_norm() <= usual_) && !undoing && !fields_are_finite()) {
        // Goes back to the copy and from there to the state before this step.
        state_ = before_;
        step_ -= since_copy_;
        steps = 1 + std::exchange(since_copy_, 0);
        undoing = true;
        continue;
      }
      ++step_;
      if (!only_rotates) ++since_copy_;
    }
    return {undoing ? Outcome::not_finite : Outcome::reached, std::nullopt};
  }

  /// Returns |x|², or what the map keeps that grows with it.
  double squared_norm() const {
    if constexpr (requires { state_.squared_norm(); })
      return static_cast<double>(state_.squared_norm());
    else
      return static_cast<double>(state_.x.value.squaredNorm());
  }

  /// Whether the fields of a state that has grown far beyond the start are finite: those that are
  /// much larger than the state are sums of products of two of its numbers, the others are written.
  [[gnu::noinline]] bool fields_are_finite() const {
    if (!std::isfinite(squared_norm())) return false;
    std::vector<double> numbers;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if (fields_[i].size() > 4 * state_.x.value.size()) continue;
      numbers.resize(static_cast<std::size_t>(fields_[i].size()));
      write(i, numbers);
      if (!std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); })) return false;
    }
    return true;
  }

  RunStatus step_of_map(const std::stop_token& stop, bool may_stop) {
    if (may_stop && stop.stop_requested()) return RunStatus{Outcome::cancelled, std::nullopt};
    ++map_steps_;
    if constexpr (requires { map_.step(state_, stop); })
      return map_.step(state_, stop);
    else
      return map_.step(state_);
  }

  /// Names the largest step in the status of a step of the scene that left the domain. The map
  /// named the one from the state of the substep that has no solution.
  RunStatus left_domain(RunStatus status, const std::stop_token& stop) const {
    if (!make_) return status;
    const auto reached = unless_stopped(stop, [&] { return largest_of_all_substeps(); });
    if (!reached) return {Outcome::cancelled, std::nullopt};
    status.largest_step.reset();
    if (*reached > 0 && *reached < 1) status.largest_step = *reached * step_of_map_;
    return status;
  }

  /// Returns the largest t with which the state has all substeps of length t·h, to 1e-3; to 5 %
  /// where shorter steps have none.
  double largest_of_all_substeps() const {
    constexpr double longer = 1.05;
    const auto has_all = [&](double t) { return has_all_substeps(t); };
    double reached = continuation(1, has_all);
    while (reached > 0 && reached < 1 && has_all(longer * reached)) reached *= longer;
    return reached;
  }

  /// Whether the state has all substeps of length t·h.
  bool has_all_substeps(double t) const {
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
  Observables observables_;
  int substeps_;
  double step_of_map_;  ///< |h|; 0 for a discrete system without a step
  double step_cost_;
  bool stops_inside_ = false;
  mutable typename F::State state_;  // mutable because `each` serves both saving and restoring
  typename F::State before_;         ///< the state since_copy_ steps before
  int since_copy_ = between_copies;
  std::size_t saved_size_ = 0;
  std::int64_t map_steps_ = 0;
  double usual_ = 0;  ///< |x|² up to which every field is finite
};

}  // namespace stiefel
