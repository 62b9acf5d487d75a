#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <span>

#include "engine/methods/method.h"

namespace stiefel {

/// The exact motion, where a closed form is known: the state at step k is computed from the state
/// at step 0, at the same cost for every k. Computed in extended precision in both arithmetics, so
/// rounding errors do not accumulate.
///
///     rigid body, N = 3              EulerTop
///     rigid body, Λ of two values    TwoValuedBody
///     V(n, N), Λ = λI                IsotropicGeodesic
struct Exact {
  static constexpr MethodTraits traits = {
      .name = method_name::exact,
      .summary = "closed form; in three dimensions Jacobi's elliptic functions",
      .source =
          "Jacobi 1849; Celledoni, Fasso, Safstrom and Zanna 2008; Edelman, Arias and Smith 1998",
      .file = "engine/methods/exact.h",
      .orders = {},
      .default_order = 0,
      .reversible = true,
  };
  static constexpr Conservation conservation(const SystemTraits&, std::string_view) {
    return Conservation::exact;
  }
};

/// A motion in closed form. A Point is the state of a system.
template <class Point>
class ClosedForm {
 public:
  using Scalar = typename Point::Scalar;
  using Wide = Extended<Scalar>;
  virtual ~ClosedForm() = default;
  /// Sets x to the state after k steps of length h, rounded, and returns true; false where that is
  /// not finite.
  virtual bool at(Wide k, Scalar h, Point& x) = 0;
  /// Sets x to the state at the first of several times. The others are a hint of what the next
  /// calls will ask for, so that their states can be computed together.
  virtual bool at(std::span<const Scalar> times, Point& x) { return at(1, times[0], x); }
};

/// The map of motions in closed form, compiled once for all systems with the same states. Its state
/// holds the motion, which `start` makes from the state at step 0.
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
  static bool stops_before_change() { return true; }

  RunStatus step(State& state) const { return {at(state, Wide(state.steps(0)) + 1), std::nullopt}; }
  Outcome at(State& state, Wide k) const {
    if (!state.motion->at(k, h_, state.x.value)) return Outcome::not_finite;
    state.steps(0) = static_cast<Scalar>(k);
    return Outcome::reached;
  }
  Outcome at(State& state, std::span<const Scalar> times) const {
    return state.motion->at(times, state.x.value) ? Outcome::reached : Outcome::not_finite;
  }

  std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

 private:
  Make make_;
  Scalar h_;
};

/// Returns the map of the motions make(start), whose `at(t)` returns the state at time t.
template <class Point, class Make>
ClosedFormMap<Point> closed_form_map(Make make, typename Point::Scalar h) {
  using Form = ClosedForm<Point>;
  using Motion = decltype(make(std::declval<const Point&>()));
  struct OfMotion final : Form {
    explicit OfMotion(Motion of) : motion(std::move(of)) {}
    using Form::at;
    bool at(typename Form::Wide k, typename Form::Scalar h, Point& x) override {
      using std::isfinite;
      const auto& wide = motion.at(k * typename Form::Wide(h));
      const auto rounded = wide.template cast<typename Form::Scalar>();
      if (!isfinite(rounded.squaredNorm())) return false;
      x = rounded;
      return true;
    }
    Motion motion;
  };
  return {[make](const Point& start) { return std::make_shared<OfMotion>(make(start)); }, h};
}

}  // namespace stiefel
