#pragma once

#include "engine/methods/support/method.h"

namespace stiefel {

/// The exact motion, where a closed form is known: the state at step k is computed from the state
/// at step 0, at the same cost for every k. Computed in extended precision in both arithmetics, so
/// rounding errors do not accumulate.
///
/// `MotionOf<S>::make(system, start)` returns the motion of S from a state; its `at(t)` returns the
/// state at time t. `takes(Λ)` tells whether there is a closed form for this Λ, and `where` says so
/// in words.
///
///     rigid body, N = 3              EulerTop
///     rigid body, Λ of two values    TwoValuedBody
///     V(n, N), Λ = λI                IsotropicGeodesic
struct Exact {
  static constexpr MethodTraits traits = {
      .name = "exact",
      .summary = "closed form; in three dimensions Jacobi's elliptic functions",
      .source =
          "Jacobi 1849; Celledoni, Fasso, Safstrom and Zanna 2008; Edelman, Arias and Smith 1998",
      .file = "engine/methods/exact.h",
      .orders = {},
      .default_order = 0,
      .reversible = true,
  };

  template <class S>
  struct MotionOf;
  template <class S>
  static constexpr bool has_map_for = requires {
    &MotionOf<S>::make;
  };
  template <class S>
  static bool takes(const Eigen::VectorXd& lambda) {
    return MotionOf<S>::takes(lambda);
  }
  template <class>
  static constexpr Conservation conservation(std::string_view) {
    return Conservation::exact;
  }

  template <class S, Arithmetic>
  requires has_map_for<S>
  class Map {
   public:
    using Scalar = typename S::Scalar;
    using Wide = Extended<Scalar>;
    using Point = typename S::State;
    using Motion =
        decltype(MotionOf<S>::make(std::declval<const S&>(), std::declval<const Point&>()));

    /// The state holds the motion, which `start` makes from the state at step 0.
    struct State {
      Accumulator<Point, Arithmetic::plain> x;
      Eigen::Matrix<Scalar, 1, 1> steps;
      Motion motion;

      template <class Visitor>
      void each(Visitor&& visit) {
        x.each(visit);
        visit(steps);
      }
    };

    Map(S system, Scalar h, int) : system_(std::move(system)), h_(h) {}

    State start(const Point& x) const {
      return {Accumulator<Point, Arithmetic::plain>(x), Eigen::Matrix<Scalar, 1, 1>::Zero(),
              MotionOf<S>::make(system_, x)};
    }

    RunStatus step(State& state) const { return at(state, Wide(state.steps(0)) + 1); }

    /// Sets the state to that k steps after step 0.
    RunStatus at(State& state, Wide k) const {
      using std::isfinite;
      const auto& x = state.motion.at(k * Wide(h_));
      if (!isfinite(x.template cast<Scalar>().squaredNorm()))
        return {Outcome::not_finite, std::nullopt};
      state.x.value = x.template cast<Scalar>();
      state.steps(0) = static_cast<Scalar>(k);
      return {};
    }

    std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

   private:
    S system_;
    Scalar h_;
  };
};

}  // namespace stiefel
