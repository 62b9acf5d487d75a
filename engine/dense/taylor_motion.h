#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Returns the most economical order of a Taylor series for a relative truncation error ε: p ≈ −½
/// ln ε (Jorba and Zou 2005, §3.1).
inline int taylor_order(double epsilon) {
  return std::max(6, static_cast<int>(std::ceil(-std::log(epsilon) / 2)) + 1);
}

/// A motion computed by a sequence of Taylor series. Each series is used as long as its last two
/// coefficients keep the truncation error below ε, relative to the frame and to the momentum. The
/// motion can be evaluated at any times in ascending |t|.
///
/// `Series` is TaylorRigidBody, TaylorParametricRigidBody, TaylorStiefel or TaylorDoubleBracket, in
/// any Scalar.
template <class Series>
class TaylorMotion {
 public:
  using Scalar = typename Series::Scalar;

  TaylorMotion(Series series, Matrix<Scalar> start, double epsilon)
      : series_(std::move(series)), x_(start), start_(std::move(start)), epsilon_(epsilon) {}

  /// The span of a series for a motion at rest.
  static constexpr double longest = 1e12;

  /// Moves to time t, which must not be before the time of the last call. Returns false, and keeps
  /// the state that was reached, when `stopped` returns true or the motion ends.
  bool go_to(double t, const std::function<bool()>& stopped) {
    using std::abs;
    for (;;) {
      if (length_ == 0 && !expand(stopped)) return false;
      const Scalar ahead = Scalar(t) - from_;
      if (abs(ahead) <= length_) {
        x_ = value(ahead);
        return true;
      }
      const Scalar whole = ahead < 0 ? -length_ : length_;
      start_ = value(whole);
      from_ += whole;
      if (!start_.allFinite()) return false;
      length_ = 0;
    }
  }

  const Matrix<Scalar>& state() const { return x_; }
  /// Returns the time that the last series spans.
  double span() const { return static_cast<double>(length_); }
  /// Returns the number of series so far.
  std::int64_t series_count() const { return count_; }

 private:
  bool expand(const std::function<bool()>& stopped) {
    if (!series_.expand(start_, coefficients_, stopped)) return false;
    ++count_;
    length_ = Scalar(reach());
    return length_ > 0;
  }

  auto coefficient(int k) const {
    const Eigen::Index N = start_.cols();
    return coefficients_.middleCols(k * N, N);
  }

  /// Evaluates the series at t by Horner's rule.
  Matrix<Scalar> value(const Scalar& t) const {
    Matrix<Scalar> sum = coefficient(series_.order());
    for (int k = series_.order() - 1; k >= 0; --k) sum = (sum * t + coefficient(k)).eval();
    return sum;
  }

  /// Returns the time up to which the terms of the last two coefficients stay below ε, relative to
  /// the largest element of the frame and to that of the momentum.
  double reach() const {
    const Eigen::Index momentum = series_.momentum_rows(), frame = start_.rows() - momentum;
    double reach = std::numeric_limits<double>::infinity();
    const auto within = [&](Eigen::Index from, Eigen::Index rows) {
      const auto size = [&](int k) {
        using std::log;
        return static_cast<double>(
            log(coefficient(k).middleRows(from, rows).cwiseAbs().maxCoeff()));
      };
      for (const int k : {series_.order() - 1, series_.order()})
        reach = std::min(reach, std::exp((std::log(epsilon_) + size(0) - size(k)) / k));
    };
    if (frame > 0) within(0, frame);
    within(frame, momentum);
    return std::min(reach, longest);
  }

  Series series_;
  Matrix<Scalar> x_, start_, coefficients_;
  double epsilon_;
  Scalar from_ = 0, length_ = 0;
  std::int64_t count_ = 0;
};

}  // namespace stiefel
