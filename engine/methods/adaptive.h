#pragma once

#include <algorithm>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <stop_token>
#include <vector>

#include "engine/methods/support/method.h"
#include "engine/methods/support/concepts.h"
#include "stiefel/invariant_names.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The Runge–Kutta–Fehlberg pair of orders 7 and 8 (Fehlberg 1968; Boost.odeint's) with automatic
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
      .source = "Fehlberg 1968; Boost.odeint",
      .file = "engine/methods/adaptive.h",
      .orders = {8},
      .default_order = 8,
      .reversible = false,
      .default_tolerance = 1e-9,
  };
  static constexpr int most_substeps = 10000;
  static constexpr int stages = 13;

  static constexpr bool applies_to(const SystemTraits&) { return true; }
  static constexpr Conservation conservation(const SystemTraits& system,
                                             std::string_view invariant) {
    return system.projects && invariant == family::orthogonality ? Conservation::exact
                                                                 : Conservation::drifts;
  }

  template <System S, Arithmetic arithmetic>
  class Map {
   public:
    using Point = typename S::State;
    using Scalar = typename S::Scalar;
    using State = PlainState<S, arithmetic>;

    Map(S system, Scalar h, int, double tolerance = traits.default_tolerance)
        : system_(std::move(system)), h_(h), tolerance_(tolerance) {}

    State start(const Point& x) {
      prepare(x);
      return State{Accumulator<Point, arithmetic>(x)};
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

    /// Returns the number of substeps tried so far.
    std::int64_t attempts() const { return attempts_; }

   private:
    using Numbers = std::vector<Scalar>;

    /// The stride that was rejected last, from the same state; 0 if there is none.
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

    void prepare(const Point& x) {
      if (!x_.empty()) return;
      point_ = slope_ = dx_ = x;
      const auto size = static_cast<std::size_t>(x.size());
      for (Numbers* v : {&x_, &next_, &slope_now_, &error_}) v->resize(size);
    }

    /// Sets x_ to x(t + h).
    Outcome integrate(const std::stop_token& stop) {
      constexpr double least = 0.1, most = 5, safety = 0.9, least_stride = 1e-12;
      const Scalar blown_up = 1e6, size_before = size();
      const auto field = [this](const Numbers& x, Numbers& dx, Scalar) { evaluate(x, dx); };
      double done = 0, stride = 1;  // in units of h
      double allowed = 1;           // the largest `excess` that is accepted
      Rejected rejected;
      field(x_, slope_now_, Scalar(0));
      for (int k = 0; k < most_substeps; ++k) {
        if (stop.stop_requested()) return Outcome::cancelled;
        stop_point(static_cast<double>(stages * x_.size()));
        const bool last = done + stride >= 1;
        if (last) stride = 1 - done;
        ++attempts_;
        stepper_.do_step(field, x_, slope_now_, Scalar(0), next_, static_cast<Scalar>(stride) * h_,
                         error_);
        const double error = relative_error(), excess = error / (tolerance_ * stride);
        if (excess > allowed && rejected.persists(excess, stride, error)) allowed = 2 * excess;
        const double factor = safety * std::pow(excess / allowed, -1.0 / 7);
        if (excess <= allowed) {
          x_.swap(next_);
          if (last) return Outcome::reached;
          done += stride;
          field(x_, slope_now_, Scalar(0));
          stride *= std::clamp(factor, least, most);
          rejected = {};
        } else {  // the error is too large, or NaN
          rejected = {excess, stride};
          stride *= factor >= least ? factor : least;
        }
        if (stride < least_stride) break;
      }
      // The stride tends to 0 where the solution ends.
      return finite(next_) && size() <= blown_up * size_before ? Outcome::solver_stalled
                                                               : Outcome::not_finite;
    }

    void evaluate(const Numbers& x, Numbers& dx) {
      std::copy_n(x.data(), x.size(), point_.data());
      system_.field(point_, slope_);
      std::copy_n(slope_.data(), dx.size(), dx.data());
    }

    /// Returns the largest error, relative in each half of the rows to the largest element of that
    /// half.
    double relative_error() const {
      const Eigen::Index rows = dx_.rows(), cols = dx_.cols(), lower = rows / 2;
      const Eigen::Map<const Matrix<Scalar>> x(x_.data(), rows, cols),
          next(next_.data(), rows, cols), error(error_.data(), rows, cols);
      const auto part = [&](Eigen::Index from, Eigen::Index count) {
        const Scalar size = std::max<Scalar>(x.middleRows(from, count).cwiseAbs().maxCoeff(),
                                             next.middleRows(from, count).cwiseAbs().maxCoeff());
        const Scalar largest = error.middleRows(from, count).cwiseAbs().maxCoeff();
        return largest == 0 ? 0.0 : static_cast<double>(largest / size);
      };
      if (!finite(next_) || !finite(error_)) return std::numeric_limits<double>::infinity();
      return lower == 0 ? part(0, rows)
                        : std::max(part(0, rows - lower), part(rows - lower, lower));
    }

    Scalar size() const {
      return Eigen::Map<const Vector<Scalar>>(x_.data(), static_cast<Eigen::Index>(x_.size()))
          .cwiseAbs()
          .maxCoeff();
    }

    static bool finite(const Numbers& x) {
      return Eigen::Map<const Vector<Scalar>>(x.data(), static_cast<Eigen::Index>(x.size()))
          .allFinite();
    }

    S system_;
    Scalar h_;
    double tolerance_;
    std::int64_t attempts_ = 0;
    boost::numeric::odeint::runge_kutta_fehlberg78<Numbers, Scalar> stepper_;
    Numbers x_, next_, slope_now_, error_;
    Point point_, slope_, dx_;
  };
};

}  // namespace stiefel
