#pragma once

#include <cmath>
#include <type_traits>

#include "engine/dense/anderson.h"
#include "engine/dense/continuation.h"
#include "engine/dense/history.h"
#include "engine/dense/newton_krylov.h"
#include "engine/methods/method.h"
#include "engine/numbers/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Solves z = g(z) to rounding. Makes plain sweeps while each removes most of the error, and then
/// mixes the last few by Anderson's method. Allocates at construction only.
class FixedPoint {
 public:
  FixedPoint(Eigen::Index rows, Eigen::Index cols) : anderson_(rows, cols, 5) {}

  /// Starts from the given z; `sweep(z, g)` sets g = g(z). Ends when the residual is at rounding
  /// level or stagnates just above it. Returns false, and leaves z undefined, if the iteration does
  /// not converge.
  template <class Sweep>
  bool solve(Matrix<double>& z, Sweep&& sweep) {
    constexpr double unit = std::numeric_limits<double>::epsilon(), swift = 0.25, slow = 0.7;
    constexpr int most = 100;
    double last = 0;
    bool mixing = false;
    anderson_.restart();
    for (int k = 0; k < most; ++k) {
      stop_point(20.0 * static_cast<double>(z.size()));
      Matrix<double>&g = anderson_.g(), &f = anderson_.f();
      sweep(z, g);
      f = g - z;
      if (!((0 * f).sum() == 0)) return false;  // an element is infinite or not a number
      const double error = f.cwiseAbs().maxCoeff(), size = g.cwiseAbs().maxCoeff();
      const double ratio = k == 0 ? slow : error / last;
      const double expected = mixing || ratio > slow ? slow : ratio;
      z = g;
      if (error * expected <= unit / 2 * size || (ratio > slow && error <= 16 * unit * size))
        return true;
      mixing = mixing || (k > 0 && ratio > swift);
      anderson_.keep();
      if (mixing) anderson_.mix(z);
      last = error;
    }
    return false;
  }

 private:
  Anderson anderson_;
};

/// Base class of implicit methods: a map x ← x + Δ(x, z), where z is the solution of z = g(x, z, h)
/// on the branch that starts at h = 0. `Derived` has
///
///     begin(x, z)             sets z to the solution at h = 0, with the shape of the unknown,
///     sweep(x, z, h, g)       sets g = g(x, z, h),
///     displacement(x, z, dx)  sets dx = Δ.
///
/// The iteration starts from the solution extrapolated from the last steps and ends at rounding
/// level. Newton's method takes over where the fixed-point iteration does not converge, because a
/// widely spread Λ makes the equation stiff. If both fail, the solution is followed from h = 0; if
/// its branch ends before h, the step ends with left_domain.
template <class Derived, class S>
class ImplicitMap {
 public:
  using Point = typename S::State;
  using Scalar = typename S::Scalar;

  using Memory = History<Scalar, 4>;
  using State = StateWithMemory<Point, Memory>;

  ImplicitMap(S system, Scalar h, Arithmetic arithmetic)
      : system_(std::move(system)), h_(h), arithmetic_(arithmetic), solver_(0, 0) {}

  State start(const Point& x) {
    prepare(x);
    return {Accumulator<Point>(x, arithmetic_), Memory(z_.rows(), z_.cols())};
  }

  RunStatus step(State& state) {
    const Point& x = state.x.value;
    prepare(x);
    if (!state.memory.predict(z_)) derived().begin(x, z_);
    found_ = z_;
    if (!solve(x, h_)) {
      if (!x.allFinite()) return {Outcome::not_finite, std::nullopt};
      const double reached = follow(x, 1);
      if (reached == 0) return {Outcome::solver_stalled, std::nullopt};
      if (reached < 1) return {Outcome::left_domain, reached * length()};
    }
    derived().displacement(x, z_, dx_);
    if (!(x + dx_).allFinite()) return {Outcome::not_finite, std::nullopt};
    state.x.add(dx_);
    state.memory.push(z_);
    return {};
  }

  /// Returns the largest |h| up to `limit` to which the solution can be followed from `state`, to
  /// 1e-3.
  std::optional<double> largest_step(const State& state, double limit) {
    prepare(state.x.value);
    return follow(state.x.value, limit / length()) * length();
  }

 protected:
  S system_;
  Scalar h_;

 private:
  Derived& derived() { return static_cast<Derived&>(*this); }
  double length() const { return std::abs(static_cast<double>(h_)); }

  /// Allocates at the first call, because `Derived` determines the shape of the unknown.
  void prepare(const Point& x) {
    if (z_.size() > 0) return;
    dx_ = x;
    derived().begin(x, z_);
    solver_ = FixedPoint(z_.rows(), z_.cols());
  }

  /// Solves from z_, which must equal found_ at the call; in wider numbers than double by Newton's
  /// method alone.
  bool solve(const Point& x, Scalar h) {
    const auto sweep = [&](const auto& z, auto& g) { derived().sweep(x, z, h, g); };
    if constexpr (std::is_same_v<Scalar, double>) {
      if (solver_.solve(z_, sweep)) return true;
      z_ = found_;
    }
    return newton_.solve(z_, sweep);
  }

  double follow(const Point& x, double end) {
    derived().begin(x, z_);
    return continuation(end, [&](double t) {
      found_ = z_;
      if (solve(x, static_cast<Scalar>(t) * h_)) return true;
      z_ = found_;
      return false;
    });
  }

  Arithmetic arithmetic_;
  FixedPoint solver_;
  NewtonKrylov<Scalar> newton_;
  Matrix<Scalar> z_, found_;
  Point dx_;
};

}  // namespace stiefel
