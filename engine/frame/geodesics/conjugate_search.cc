#include "engine/frame/geodesics/conjugate_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/dense/decompositions.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double pi = std::numbers::pi;

/// Returns the angles of tan θ = ωAB⁻¹ in [0, π), ascending, from cot(θ − α), with the α for which
/// this is best conditioned.
VectorXd lagrangian_angles(const MatrixXd& A, const MatrixXd& B, double omega) {
  constexpr int candidates = 8;
  const double d = static_cast<double>(A.cols());
  stop_point(candidates * d * d * d + 2000);
  double best = -1, alpha = 0;
  MatrixXd cotangent;
  for (int k = 0; k < candidates; ++k) {
    const double angle = (k + 0.3) * pi / candidates, c = std::cos(angle), s = std::sin(angle);
    const Lu<double> sine((omega * c * A - s * B).transpose());
    const double quality = sine.inverse_condition();
    if (quality <= best) continue;
    best = quality;
    alpha = angle;
    cotangent = sine.solve((omega * s * A + c * B).transpose());
  }
  const MatrixXd symmetric = (cotangent + cotangent.transpose()) / 2;
  VectorXd angles = symmetric_eigenvalues(symmetric);
  for (double& angle : angles) {
    angle = alpha + std::atan2(1, angle);
    if (angle >= pi) angle -= pi;
  }
  std::sort(angles.begin(), angles.end());
  return angles;
}

}  // namespace

ConjugateSearch::ConjugateSearch(const VectorXd& lambda, const MatrixXd& Q, const MatrixXd& V)
    : flow_(JacobiFlow::make(lambda, Q.rows())),
      E_(flow_->basis(Q)),
      x_(flow_->start(Q, V, E_)),
      to_start_(MatrixXd::Identity(E_.cols(), E_.cols())),
      next_(1 / (static_cast<double>(E_.cols()) * flow_->curvature(x_))) {}

ConjugateSearch::Family ConjugateSearch::after(double h, double omega) {
  Family family;
  flow_->step(x_, h, family.x, error_);
  auto [A, B] = flow_->coordinates(family.x);
  family.A = std::move(A);
  family.B = std::move(B);
  family.angles = lagrangian_angles(family.A, family.B, omega);
  return family;
}

/// Returns how many angles have passed a multiple of π since x_; −1 where they have moved too far.
int ConjugateSearch::crossed(const Family& later) const {
  constexpr double farthest = 1.4;
  const double moved = later.angles.sum() - angles_.sum(), count = std::round(-moved / pi);
  if (!(std::abs(moved + count * pi) <= farthest)) return -1;
  return static_cast<int>(count);
}

bool ConjugateSearch::advance(double limit, std::vector<Crossing>& crossings) {
  constexpr double tolerance = 1e-14, next_to_a_crossing = 1e-7;
  constexpr int attempts = 60;
  const double d = static_cast<double>(E_.cols());
  double h = std::min({next_, 1 / (d * flow_->curvature(x_)), limit - length_});
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const double omega = 1 / (d * h);
    Family next = after(h, omega);
    double error = 0, size = 0;
    for (std::size_t k = 0; k < error_.size(); ++k) {
      error = std::max(error, std::abs(error_[k]));
      size = std::max(size, std::abs(next.x[k]));
    }
    if (!std::isfinite(size)) {
      h /= 4;
      continue;
    }
    const double grown = 0.9 * std::pow(tolerance * size / (error + 1e-300), 0.125);
    if (error > 2 * tolerance * size) {
      h *= std::clamp(grown, 0.2, 0.9);
      continue;
    }
    if (h * d * flow_->curvature(next.x) > 2) {
      h /= 2;
      continue;
    }
    angles_ = length_ == 0 ? VectorXd::Zero(E_.cols()).eval() : [&] {
      const auto [A, B] = flow_->coordinates(x_);
      return lagrangian_angles(A, B, omega);
    }();
    const int count = crossed(next);
    const double nearest = std::min(next.angles(0), pi - next.angles(next.angles.size() - 1));
    if (count < 0) {
      h /= 2;
      continue;
    }
    if (nearest < next_to_a_crossing && h < limit - length_ && attempt < attempts / 2) {
      h *= 0.93;
      continue;
    }
    std::vector<double> at;
    for (int k = 0; k < count; ++k) at.push_back(locate(h, omega, count, k));
    std::ranges::sort(at);
    for (std::size_t first = 0, last; first < at.size(); first = last) {
      for (last = first + 1; last < at.size(); ++last)
        if (at[last] - at[last - 1] > merged * (length_ + at[last])) break;
      double mean = 0;
      for (std::size_t k = first; k < last; ++k) mean += at[k] / static_cast<double>(last - first);
      crossings.push_back(crossing(mean, static_cast<int>(last - first)));
    }
    next_ = h * std::clamp(grown, 0.2, 4.0);
    take(std::move(next), h, omega);
    return true;
  }
  return false;
}

/// Returns the time after x_, at most h, at which the angle `index` of those that cross does so.
double ConjugateSearch::locate(double h, double omega, int count, int index) {
  constexpr int iterations = 100;
  constexpr double rounding = 4e-16;
  double low = 0, high = h, at = h;
  int crossed_at = count;
  for (int k = 0; k < iterations; ++k) {
    const Family family = after(at, omega);
    if (k > 0) crossed_at = crossed(family);
    (crossed_at > index ? high : low) = at;
    // To first order in the time an angle grows by ω where it is a multiple of π.
    const VectorXd& angles = family.angles;
    const Index last = angles.size() - 1;
    const double angle = crossed_at > index
                             ? angles(std::min<Index>(crossed_at - 1 - index, last))
                             : angles(std::max<Index>(last - (index - crossed_at), 0)) - pi;
    const double move = -std::tan(angle) / omega;
    double next = at + move;
    if (!(next > low && next < high) || std::abs(angle) > 1) next = (low + high) / 2;
    const bool settled = std::abs(next - at) <= rounding * (length_ + at);
    at = next;
    if (settled || high - low <= rounding * (length_ + at)) break;
  }
  return at;
}

Crossing ConjugateSearch::crossing(double at, int multiplicity) {
  const double omega = 1 / (length_ + at);
  const Family family = after(at, omega);
  const Index d = E_.cols();
  // In orthonormal columns of (ωA; B) the singular values of ωA are the sines of the angles.
  MatrixXd both(2 * d, d);
  both << omega * family.A, family.B;
  const MatrixXd R = triangular_factor(both);
  const MatrixXd sines =
      R.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(omega * family.A);
  const auto [values, vectors] = right_singular(sines);
  const MatrixXd kernel =
      to_start_ * R.triangularView<Eigen::Upper>().solve(vectors.rightCols(multiplicity));
  const MatrixXd W = orthonormal_columns(kernel, multiplicity);
  const double gap =
      multiplicity < d ? values(d - 1 - multiplicity) : std::numeric_limits<double>::infinity();
  return {length_ + at, multiplicity, E_ * W, gap};
}

/// Goes on from `next` with fields whose (ωA; B) are orthonormal.
void ConjugateSearch::take(Family&& next, double h, double omega) {
  const Index d = E_.cols();
  MatrixXd both(2 * d, d);
  both << omega * next.A, next.B;
  const MatrixXd R = triangular_factor(both);
  x_ = std::move(next.x);
  auto fields = flow_->fields(x_);
  fields = R.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(MatrixXd(fields));
  to_start_ = R.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(to_start_).eval();
  to_start_ /= to_start_.cwiseAbs().maxCoeff();
  length_ += h;
}

}  // namespace stiefel
