#pragma once

#include <cmath>
#include <functional>
#include <memory>

#include "engine/methods/method.h"

namespace stiefel {

/// A motion in closed form. A Point is the state of a system.
template <class Point>
class ClosedForm {
 public:
  using Wide = Extended<typename Point::Scalar>;
  virtual ~ClosedForm() = default;
  /// Returns the state at time t, rounded.
  virtual const Point& at(Wide t) = 0;
};

template <class Point, class Motion>
std::shared_ptr<ClosedForm<Point>> closed_form(Motion motion) {
  struct Held final : ClosedForm<Point> {
    explicit Held(Motion m) : motion(std::move(m)) {}
    const Point& at(typename ClosedForm<Point>::Wide t) override {
      const auto& wide = motion.at(t);
      return x = wide.template cast<typename Point::Scalar>();
    }
    Motion motion;
    Point x;
  };
  return std::make_shared<Held>(std::move(motion));
}

/// The map of a motion in closed form, compiled once for all systems with the same states. Its
/// state holds the motion, which `start` makes from the state at step 0.
template <class Point_>
class ClosedFormMap {
 public:
  using Point = Point_;
  using Scalar = typename Point::Scalar;
  using Wide = Extended<Scalar>;
  using Make = std::function<std::shared_ptr<ClosedForm<Point>>(const Point& start)>;

  struct State {
    Accumulator<Point> x;
    Eigen::Matrix<Scalar, 1, 1> steps;
    std::shared_ptr<ClosedForm<Point>> motion;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
      visit(steps);
    }
  };

  ClosedFormMap(Make make, Scalar h) : make_(std::move(make)), h_(h) {}

  State start(const Point& x) const {
    return {{x, Arithmetic::plain}, Eigen::Matrix<Scalar, 1, 1>::Zero(), make_(x)};
  }

  RunStatus step(State& state) const { return at(state, Wide(state.steps(0)) + 1); }

  /// Sets the state to that k steps after step 0.
  RunStatus at(State& state, Wide k) const {
    using std::isfinite;
    const Point& x = state.motion->at(k * Wide(h_));
    if (!isfinite(x.squaredNorm())) return {Outcome::not_finite, std::nullopt};
    state.x.value = x;
    state.steps(0) = static_cast<Scalar>(k);
    return {};
  }

  std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

 private:
  Make make_;
  Scalar h_;
};

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
      .momentum_alone = true,
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

  template <class S>
  requires has_map_for<S>
  class Map : public ClosedFormMap<typename S::State> {
   public:
    using Moved = ClosedFormMap<typename S::State>;
    Map(const S& system, typename S::Scalar h, const MethodOptions&)
        : Moved(
              [system](const typename S::State& start) {
                return closed_form<typename S::State>(MotionOf<S>::make(system, start));
              },
              h) {}
  };
};

}  // namespace stiefel
