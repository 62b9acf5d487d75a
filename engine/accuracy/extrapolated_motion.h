#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "engine/numbers/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// A motion x' = field(x) by Gragg's extrapolation (Hairer, Norsett and Wanner, Solving Ordinary
/// Differential Equations I, II.9): Gragg's midpoint rule with 2, 4, ..., 2k substeps of a stride
/// H, extrapolated in the square of the substep to order 2k. In an accepted stride the last two
/// columns differ by at most `tolerance`, relative to the largest element of the frame and to that
/// of the block below it, or by rounding. The motion can be evaluated at any times in ascending
/// |t|.
template <class Scalar>
class ExtrapolatedMotion {
 public:
  using State = Matrix<Scalar>;
  using Field = std::function<void(const State& x, State& dx)>;

  /// `first` > 0 is the length of the first stride that is tried.
  ExtrapolatedMotion(Field field, State start, Eigen::Index frame_rows, int columns,
                     double tolerance, double first)
      : field_(std::move(field)),
        x_(std::move(start)),
        frame_rows_(frame_rows),
        columns_(static_cast<std::size_t>(columns)),
        tolerance_(tolerance),
        stride_(first),
        row_(columns_),
        last_(columns_) {}

  /// Moves to time t, which must not be before the time of the last call. Returns false, and keeps
  /// the state that was reached, when `stopped` returns true or the motion ends.
  template <class Stopped>
  bool go_to(double t, Stopped&& stopped) {
    while (Scalar(t) != time_) {
      if (stopped() || !go_on(Scalar(t))) return false;
    }
    return true;
  }

  const State& state() const { return x_; }
  /// Returns the length of the next stride.
  double stride() const { return static_cast<double>(stride_); }
  /// Returns the number of evaluations of the field so far.
  std::int64_t evaluations() const { return evaluations_; }
  static std::int64_t evaluations_of_stride(int columns) {
    return std::int64_t{columns} * (columns + 2);
  }

 private:
  /// Makes one stride towards t, or up to t.
  bool go_on(const Scalar& t) {
    using std::abs, std::pow;
    Scalar rejected = 0;
    for (;;) {
      const Scalar left = abs(t - time_);
      const bool last = stride_ >= left;
      const Scalar H = (t < time_ ? -1 : 1) * (last ? left : stride_);
      if (!(abs(H) > abs(time_) * std::numeric_limits<Scalar>::epsilon())) return false;
      const Scalar error = extrapolate(H);
      // If a shorter stride has about the same error, all of the error is rounding.
      const bool rounding = rejected > 0 && 2 * error > rejected;
      const bool good = error <= Scalar(tolerance_) || rounding;
      const Scalar power = Scalar(1) / static_cast<int>(2 * columns_ - 1);
      const Scalar factor =
          error > 0 ? pow(Scalar(tolerance_) / error, power) * Scalar(0.9) : Scalar(2);
      if (good) {
        x_ = row_.back();
        time_ = last ? t : time_ + H;
        if (!last && !rounding) stride_ *= std::clamp(factor, Scalar(0.5), Scalar(2));
        return true;
      }
      rejected = std::isfinite(static_cast<double>(error)) ? error : Scalar(0);
      stride_ =
          abs(H) * (rejected > 0 ? std::clamp(factor, Scalar(0.1), Scalar(0.8)) : Scalar(0.1));
    }
  }

  /// Extrapolates a stride H into the last element of row_. Returns how far the column before it is
  /// from the result.
  Scalar extrapolate(const Scalar& H) {
    for (std::size_t k = 0; k < columns_; ++k) {
      midpoint_rule(H, static_cast<int>(2 * (k + 1)), row_[0]);
      for (std::size_t j = 1; j <= k; ++j) {
        const Scalar ratio = Scalar(k + 1) / Scalar(k + 1 - j);
        row_[j] = row_[j - 1] + (row_[j - 1] - last_[j - 1]) / (ratio * ratio - 1);
      }
      if (k + 1 < columns_) std::swap(row_, last_);
    }
    const State off = row_[columns_ - 1] - row_[columns_ - 2];
    if (!off.allFinite()) return std::numeric_limits<Scalar>::infinity();
    const auto part = [&](Eigen::Index from, Eigen::Index rows) {
      if (rows == 0) return Scalar(0);
      const Scalar size = x_.middleRows(from, rows).cwiseAbs().maxCoeff();
      return off.middleRows(from, rows).cwiseAbs().maxCoeff() / (size > 0 ? size : Scalar(1));
    };
    return std::max(part(0, frame_rows_), part(frame_rows_, x_.rows() - frame_rows_));
  }

  void midpoint_rule(const Scalar& H, int n, State& end) {
    const Scalar h = H / n;
    before_ = x_;
    slope(before_);
    end = x_ + h * slope_;
    for (int j = 1; j < n; ++j) {
      slope(end);
      before_ += 2 * h * slope_;
      std::swap(before_, end);
    }
  }

  void slope(const State& x) {
    stop_point(static_cast<double>(4 * x.size() * x.cols()));
    slope_.resizeLike(x);
    field_(x, slope_);
    ++evaluations_;
  }

  Field field_;
  State x_;
  Eigen::Index frame_rows_;
  std::size_t columns_;
  double tolerance_;
  Scalar stride_, time_ = 0;
  std::vector<State> row_, last_;
  State before_, slope_;
  std::int64_t evaluations_ = 0;
};

}  // namespace stiefel
