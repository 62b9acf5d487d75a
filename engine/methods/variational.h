#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "engine/dense/continuation.h"
#include "engine/methods/method.h"
#include "engine/methods/symmetric_stages.h"

namespace stiefel {

/// The variational integrator: the Moser–Veselov map for the rigid body, RATTLE on V(n, N); at n =
/// N the two are the same map. The orders 4, 6 and 8 are symmetric compositions of it.
struct Variational {
  static constexpr MethodTraits traits = {
      .name = method_name::variational,
      .summary = "discrete variational principle; at n = N the Moser-Veselov map",
      .source = "[RB] (4.5), Moser and Veselov 1991; Andersen 1983; Suzuki 1990, Kahan and Li 1997",
      .file = "engine/methods/variational.h",
      .orders = {2, 4, 6, 8},
      .default_order = 2,
      .reversible = true,
      .iterates = true,
      .in_float = true,
      .in_so4 = true,
      .packing = Packing::stages,
  };

  static constexpr Conservation conservation(const SystemTraits&, std::string_view) {
    return Conservation::exact;
  }
};

/// The symmetric composition Φ_{γ_s h} ∘ … ∘ Φ_{γ_1 h} of a symmetric map Φ of order 2. It is a map
/// of order 2 (Φ itself), 4, 6 or 8 with the invariants of Φ, at 1, 5, 9 or 17 times its cost. A
/// step exists where all stages exist; the longest stage is 0.66h, 0.80h, 0.61h for the orders 4,
/// 6, 8.
///
/// Stages of equal length share a map. Every stage has a `memory` of its own, because the solutions
/// of one stage in successive steps lie on a smooth curve, and those of successive stages do not.
template <class Base>
requires Map<Base>
class Composition {
 public:
  using Scalar = typename Base::Scalar;
  using Point = typename Base::Point;
  static constexpr bool only_rotates = requires { requires Base::only_rotates; };
  bool stops_before_change() const {
    if constexpr (requires { Base::stops_before_change(); })
      return stages_ == 1 && Base::stops_before_change();
    else
      return false;
  }
  /// Returns Φ for a given step.
  using Make = std::function<Base(Scalar)>;

  /// The state of Φ with the memory of the first stage, and the memories of the later stages.
  struct State : Base::State {
    std::vector<decltype(Base::State::memory)> later;

    State(const typename Base::State& first, std::size_t stages)
        : Base::State(first), later(stages - 1, first.memory) {}

    template <class Visitor>
    void each(Visitor&& visit) {
      Base::State::each(visit);
      for (auto& other : later) other.each(visit);
    }

    /// Exchanges the current memory with that of a stage. A second call undoes the exchange.
    void exchange(std::size_t stage) {
      if (stage > 0) std::swap(this->memory, later[stage - 1]);
    }
  };

  Composition(Make make, Scalar h, int order) : make_(std::move(make)), h_(h), order_(order) {
    const auto gamma = symmetric_stages<Scalar>(order);
    for (const Scalar& g : gamma) maps_.push_back(make_(g * h));
    stages_ = 2 * gamma.size() - 1;
  }

  State start(const Point& x) { return State(maps_.front().start(x), stages_); }

  RunStatus step(State& state) {
    if (stages_ == 1) return maps_.front().step(state);
    before_ = state;
    const RunStatus status = run(state);
    if (status.reached()) return status;
    state = *before_;
    if (status.outcome != Outcome::left_domain) return status;
    const double reached = follow(state, 1);
    if (reached == 0) return {Outcome::solver_stalled, std::nullopt};
    return {Outcome::left_domain, reached * length()};
  }

  /// Returns the largest |h| up to `limit` for which every stage from `state` exists, to 1e-3.
  std::optional<double> largest_step(const State& state, double limit) {
    if (stages_ == 1) return maps_.front().largest_step(state, limit);
    return follow(state, limit / length()) * length();
  }

  /// Makes the stages of a step. Unlike `step`, leaves the state undefined where a stage has no
  /// solution; the status is that stage's.
  RunStatus run(State& state) {
    for (std::size_t stage = 0; stage < stages_; ++stage) {
      state.exchange(stage);
      const RunStatus status = maps_[std::min(stage, stages_ - 1 - stage)].step(state);
      state.exchange(stage);
      if (!status.reached()) return status;
    }
    return {};
  }

 private:
  double follow(const State& state, double end) const {
    return continuation(end, [&](double t) {
      Composition shorter(make_, static_cast<Scalar>(t) * h_, order_);
      State trial = shorter.start(state.x.value);
      return shorter.run(trial).reached();
    });
  }

  double length() const { return std::abs(static_cast<double>(h_)); }

  Make make_;
  Scalar h_;
  int order_;
  std::vector<Base> maps_;
  std::size_t stages_;
  std::optional<State> before_;  ///< the state before the step, restored when a stage fails
};

/// Returns the composition, of the order that `options` say, of the maps order_2(h, arithmetic).
template <class Order2, class Scalar>
auto composed(Order2 order_2, Scalar h, const MethodOptions& options) {
  const auto stage = [order_2, arithmetic = options.arithmetic](Scalar of_stage) {
    return order_2(of_stage, arithmetic);
  };
  return Composition<decltype(stage(h))>(stage, h, options.order);
}

}  // namespace stiefel
