#pragma once

#include <algorithm>

#include "engine/methods/adaptive_substeps.h"
#include "engine/methods/concepts.h"
#include "engine/methods/method.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

/// The Runge–Kutta–Fehlberg pair of orders 7 and 8 (Fehlberg 1968) with automatic
/// substeps between two states. The controller keeps the estimated error of a substep of length τ
/// below `tolerance`·|τ/h|, so the error of a whole step is about `tolerance`. The error of each
/// half of the state's rows (Q, and the block below it) is relative to the largest element of that
/// half, so units do not matter. Where rounding in the vector field exceeds the tolerance, which no
/// shorter substep mends, the controller accepts errors up to twice that rounding in the rest of
/// the step. It restarts at every state.
///
/// Where the system has a manifold (`project`), the state at the end of a step is projected onto
/// it, and the next step continues from there.
///
/// Ends with solver_stalled after `most_substeps` attempts.
struct Adaptive {
  static constexpr MethodTraits traits = {
      .name = "adaptive",
      .summary = "Runge-Kutta-Fehlberg 7(8) with error control",
      .source = "Fehlberg 1968",
      .file = "engine/methods/adaptive.h",
      .orders = {8},
      .default_order = 8,
      .reversible = false,
      .default_tolerance = 1e-9,
      .momentum_alone = true,
  };
  static constexpr int most_substeps = AdaptiveSubsteps::most_substeps;
  static constexpr bool applies_to(const SystemTraits&) { return true; }
  static constexpr Conservation conservation(const SystemTraits& system,
                                             std::string_view invariant) {
    return system.projects && invariant == family::orthogonality ? Conservation::exact
                                                                 : Conservation::drifts;
  }

  template <System S>
  class Map : public AdaptiveSubsteps {
   public:
    using Point = typename S::State;
    using Scalar = typename S::Scalar;
    using State = PlainState<Point>;

    Map(S system, double h, const MethodOptions& options)
        : AdaptiveSubsteps(h, options.tolerance > 0 ? options.tolerance : traits.default_tolerance),
          system_(std::move(system)),
          arithmetic_(options.arithmetic) {}

    State start(const Point& x) {
      prepare(x);
      return State{Accumulator<Point>(x, arithmetic_)};
    }

    /// Makes one step. On a stop request ends with `cancelled` and leaves the state unchanged.
    RunStatus step(State& state, const std::stop_token& stop = {}) {
      prepare(state.x.value);
      std::copy_n(state.x.value.data(), x_.size(), x_.data());
      const Outcome outcome = integrate(stop);
      if (outcome != Outcome::reached) return {outcome, std::nullopt};
      std::copy_n(x_.data(), x_.size(), point_.data());
      if constexpr (requires { system_.project(point_); }) system_.project(point_);
      dx_ = point_ - state.x.value;
      state.x.add(dx_);
      return {};
    }

    std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

   private:
    void prepare(const Point& x) {
      if (!x_.empty()) return;
      AdaptiveSubsteps::prepare(x.rows(), x.cols());
      point_ = slope_ = dx_ = x;
    }

    void evaluate(const Numbers& x, Numbers& dx) override {
      std::copy_n(x.data(), x.size(), point_.data());
      system_.field(point_, slope_);
      std::copy_n(slope_.data(), dx.size(), dx.data());
    }

    S system_;
    Arithmetic arithmetic_;
    Point point_, slope_, dx_;
  };
};

}  // namespace stiefel
