#pragma once

#include "engine/methods/euler_top.h"
#include "engine/methods/method.h"
#include "engine/systems/rigid_body.h"

namespace stiefel {

/// The motion itself, where it is known in closed form: the state at step k comes from the state at
/// step 0, for every k in the same time. It is computed in extended precision, in both arithmetics:
/// nothing accumulates.
///
/// `MotionOf<S>::make(system, start)` is the motion of S from a state, and `at(t)` of that the
/// state at time t. Rigid body in three dimensions: EulerTop.
struct Exact {
  static constexpr MethodTraits traits = {
      .name = "exact",
      .summary = "closed form; N = 3: Jacobi's elliptic functions",
      .source = "Jacobi 1849; Celledoni, Fasso, Safstrom and Zanna 2008; Carlson 1995",
      .file = "engine/methods/exact.h",
      .orders = {},
      .default_order = 0,
      .reversible = true,
  };

  template <class S>
  struct MotionOf;
  template <class S>
  static constexpr bool applies = requires {
    &MotionOf<S>::make;
  };
  template <class>
  static constexpr Kept kept(std::string_view) {
    return Kept::exact;
  }

  template <class S, Arithmetic>
  requires applies<S>
  class Map {
   public:
    using Scalar = typename S::Scalar;
    using Wide = Extended<Scalar>;
    using Point = typename S::State;
    using Motion = decltype(MotionOf<S>::make(std::declval<const S&>(), Point()));

    /// The motion belongs to the state: `start` makes it, from the state at step 0.
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

    Ending step(State& state) const { return at(state, Wide(state.steps(0)) + 1); }

    /// The state k steps after the one that was started from.
    Ending at(State& state, Wide k) const {
      const Point x = state.motion.at(k * Wide(h_)).template cast<Scalar>();
      if (!x.allFinite()) return {Outcome::not_finite, std::nullopt};
      state.x.value = x;
      state.steps(0) = static_cast<Scalar>(k);
      return {};
    }

    std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

   private:
    S system_;
    Scalar h_;
  };
};

template <class Scalar, bool frame>
struct Exact::MotionOf<RigidBody<So3<Scalar, frame>>> {
  using Wide = Extended<Scalar>;
  static EulerTop<Wide, frame> make(const RigidBody<So3<Scalar, frame>>& body,
                                    const typename So3<Scalar, frame>::State& start) {
    return {PrincipalMoments3<Wide>(body.lambda()), start.template cast<Wide>()};
  }
};

}  // namespace stiefel
