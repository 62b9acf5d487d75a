#include "engine/methods/adaptive_substeps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Numbers = AdaptiveSubsteps::Numbers;

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

bool finite(const Numbers& x) {
  return Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()))
      .allFinite();
}

}  // namespace

void AdaptiveSubsteps::prepare(Eigen::Index rows, Eigen::Index cols) {
  if (!x_.empty()) return;
  rows_ = rows;
  cols_ = cols;
  for (Numbers* v : {&x_, &next_, &slope_now_, &error_})
    v->resize(static_cast<std::size_t>(rows * cols));
}

Outcome AdaptiveSubsteps::integrate(const std::stop_token& stop) {
  constexpr double least = 0.1, most = 5, safety = 0.9, least_stride = 1e-12;
  const double blown_up = 1e6, size_before = size();
  const auto field = [this](const Numbers& x, Numbers& dx) { evaluate(x, dx); };
  double done = 0, stride = 1;  // in units of h
  double allowed = 1;           // the largest `excess` that is accepted
  Rejected rejected;
  field(x_, slope_now_);
  for (int k = 0; k < most_substeps; ++k) {
    if (stop.stop_requested()) return Outcome::cancelled;
    stop_point(static_cast<double>(Fehlberg<double>::stages * x_.size()));
    const bool last = done + stride >= 1;
    if (last) stride = 1 - done;
    ++attempts_;
    fehlberg_.step(field, x_, slope_now_, stride * h_, next_, error_);
    const double error = relative_error(), excess = error / (tolerance_ * stride);
    if (excess > allowed && rejected.persists(excess, stride, error)) allowed = 2 * excess;
    const double factor = safety * std::pow(excess / allowed, -1.0 / 7);
    if (excess <= allowed) {
      x_.swap(next_);
      if (last) return Outcome::reached;
      done += stride;
      field(x_, slope_now_);
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

/// Returns the largest error, relative in each half of the rows to the largest element of that
/// half.
double AdaptiveSubsteps::relative_error() const {
  const Eigen::Index lower = rows_ / 2;
  const Eigen::Map<const Eigen::MatrixXd> x(x_.data(), rows_, cols_),
      next(next_.data(), rows_, cols_), error(error_.data(), rows_, cols_);
  const auto part = [&](Eigen::Index from, Eigen::Index count) {
    const double size = std::max<double>(x.middleRows(from, count).cwiseAbs().maxCoeff(),
                                         next.middleRows(from, count).cwiseAbs().maxCoeff());
    const double largest = error.middleRows(from, count).cwiseAbs().maxCoeff();
    return largest == 0 ? 0.0 : static_cast<double>(largest / size);
  };
  if (!finite(next_) || !finite(error_)) return std::numeric_limits<double>::infinity();
  return lower == 0 ? part(0, rows_) : std::max(part(0, rows_ - lower), part(rows_ - lower, lower));
}

double AdaptiveSubsteps::size() const {
  return Eigen::Map<const Eigen::VectorXd>(x_.data(), static_cast<Eigen::Index>(x_.size()))
      .cwiseAbs()
      .maxCoeff();
}

}  // namespace stiefel
