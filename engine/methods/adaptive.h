#pragma once

#include <algorithm>
#include <boost/numeric/odeint/algebra/vector_space_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <limits>
#include <stop_token>

#include "engine/methods/concepts.h"
#include "engine/methods/method.h"
#include "stiefel/invariant_names.h"
#include "stiefel/stop.h"

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
  static constexpr int most_substeps = 10000;  ///< most attempts in one step
  static constexpr bool applies_to(const SystemTraits&) { return true; }
  static constexpr Conservation conservation(const SystemTraits& system,
                                             std::string_view invariant) {
    return system.projects && invariant == family::orthogonality ? Conservation::exact
                                                                 : Conservation::drifts;
  }

  /// The substep that was rejected last, from the same state; 0 if there is none.
  struct Rejected {
    double excess = 0, stride = 0;

    /// Whether an error, the excess of which in a shorter stride is given, is one of rounding: it
    /// is small, and does not fall like the error of the method, with the seventh power of the
    /// stride, nor even with the third.
    bool persists(double now, double shorter, double error) const {
      constexpr double small = 1e-6;
      return excess > 0 && error < small && now > excess * std::pow(shorter / stride, 3);
    }
  };

  template <System S>
  class Map {
   public:
    using Point = typename S::State;
    using Scalar = typename S::Scalar;
    using State = PlainState<Point>;

    Map(S system, double h, const MethodOptions& options)
        : system_(std::move(system)),
          h_(h),
          tolerance_(options.tolerance > 0 ? options.tolerance : traits.default_tolerance),
          arithmetic_(options.arithmetic) {}

    State start(const Point& x) const { return State{Accumulator<Point>(x, arithmetic_)}; }

    /// Makes one step. On a stop request ends with `cancelled` and leaves the state unchanged.
    RunStatus step(State& state, const std::stop_token& stop = {}) {
      x_ = state.x.value;
      const Outcome outcome = integrate(stop);
      if (outcome != Outcome::reached) return {outcome, std::nullopt};
      if constexpr (requires { system_.project(x_); }) system_.project(x_);
      x_ -= state.x.value;
      state.x.add(x_);
      return {};
    }

    std::optional<double> largest_step(const State&, double) const { return std::nullopt; }
    /// Returns the number of substeps tried so far.
    std::int64_t attempts() const { return attempts_; }

   private:
    /// Sets x_ to x(t + h).
    Outcome integrate(const std::stop_token& stop) {
      constexpr double least = 0.1, most = 5, safety = 0.9, least_stride = 1e-12, blown_up = 1e6;
      const auto field = [this](const Point& x, Point& dx, double) {
        dx.resizeLike(x);
        system_.field(x, dx);
      };
      const double size_before = x_.cwiseAbs().maxCoeff();
      double done = 0, stride = 1;  // in units of h
      double allowed = 1;           // the largest `excess` that is accepted
      Rejected rejected;
      field(x_, slope_, 0);
      for (int k = 0; k < most_substeps; ++k) {
        if (stop.stop_requested()) return Outcome::cancelled;
        stop_point(13.0 * static_cast<double>(x_.size()));
        const bool last = done + stride >= 1;
        if (last) stride = 1 - done;
        ++attempts_;
        pair_.do_step(field, x_, slope_, 0.0, next_, stride * h_, error_);
        const double error = relative_error(), excess = error / (tolerance_ * stride);
        if (excess > allowed && rejected.persists(excess, stride, error)) allowed = 2 * excess;
        const double factor = safety * std::pow(excess / allowed, -1.0 / 7);
        if (excess <= allowed) {
          x_.swap(next_);
          if (last) return Outcome::reached;
          done += stride;
          field(x_, slope_, 0);
          stride *= std::clamp(factor, least, most);
          rejected = {};
        } else {  // the error is too large, or NaN
          rejected = {excess, stride};
          stride *= factor >= least ? factor : least;
        }
        if (stride < least_stride) break;
      }
      // The stride tends to 0 where the solution ends.
      return next_.allFinite() && x_.cwiseAbs().maxCoeff() <= blown_up * size_before
                 ? Outcome::solver_stalled
                 : Outcome::not_finite;
    }

    /// Returns the largest error, relative in each half of the rows to the largest element of that
    /// half.
    double relative_error() const {
      if (!next_.allFinite() || !error_.allFinite()) return std::numeric_limits<double>::infinity();
      const Eigen::Index lower = x_.rows() / 2, upper = x_.rows() - lower;
      const auto part = [&](Eigen::Index from, Eigen::Index count) {
        const auto largest = [&](const Point& of) {
          return of.middleRows(from, count).cwiseAbs().maxCoeff();
        };
        const double error = largest(error_);
        return error == 0 ? 0 : error / std::max(largest(x_), largest(next_));
      };
      return lower == 0 ? part(0, upper) : std::max(part(0, upper), part(upper, lower));
    }

    using Algebra = boost::numeric::odeint::vector_space_algebra;

    S system_;
    double h_, tolerance_;
    Arithmetic arithmetic_;
    std::int64_t attempts_ = 0;
    boost::numeric::odeint::runge_kutta_fehlberg78<Point, double, Point, double, Algebra> pair_;
    Point x_, next_, slope_, error_;
  };
};

}  // namespace stiefel
