#include "stiefel/conjugate_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "engine/frame/geodesics/jacobi_flow.h"
#include "engine/numbers/to_text.h"
#include "stiefel/scene.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using std::numbers::pi;

/// A point where the Jacobi fields J of unit speed, J(0) = 0, D_sJ(0) = E_i, become dependent.
struct Crossing {
  double length;
  int multiplicity;
  MatrixXd kernel;  ///< orthonormal D_sJ(0) of the fields that vanish, nN × multiplicity
  /// sin θ of the next angle, tan θ = |J|/(s|D_sJ|), s the length; infinite if there is none.
  double gap;
};

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

/// Moves along a geodesic and finds every conjugate point on the way. The Lagrangian angles θ_k of
/// (A, B), tan θ = ωAB⁻¹, obey θ′ = ω cos²θ + (K/ω) sin²θ along each of their directions. With |K|
/// bounded by κ², steps h ≤ 1/(dκ) and ω = 1/(dh) keep the sum of their changes within ±1, less
/// than π/2: their values modulo π then tell how many of them have passed a multiple of π, which
/// they only pass upwards.
class ConjugateSearch {
 public:
  /// Points closer than this times their length are one point.
  static constexpr double merged = 1e-10;

  /// Starts at (Q, V), tr(ΛVᵀV) = 1.
  ConjugateSearch(const VectorXd& lambda, const MatrixXd& Q, const MatrixXd& V)
      : flow_(JacobiFlow::make(lambda, Q.rows())),
        E_(flow_->basis(Q)),
        x_(flow_->start(Q, V, E_)),
        to_start_(MatrixXd::Identity(E_.cols(), E_.cols())),
        next_(1 / (static_cast<double>(E_.cols()) * flow_->curvature(x_))) {}

  /// Takes a step, at most to `limit`, and returns the crossings in it. Returns false where the
  /// geodesic cannot be continued.
  bool advance(double limit, std::vector<Crossing>& crossings) {
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
        for (std::size_t k = first; k < last; ++k)
          mean += at[k] / static_cast<double>(last - first);
        crossings.push_back(crossing(mean, static_cast<int>(last - first)));
      }
      next_ = h * std::clamp(grown, 0.2, 4.0);
      take(std::move(next), h, omega);
      return true;
    }
    return false;
  }

  double length() const { return length_; }

 private:
  struct Family {
    JacobiFlow::State x;
    MatrixXd A, B;
    VectorXd angles;  ///< in [0, π), in ascending order

    /// Returns the triangular factor of (ωA; B).
    MatrixXd triangle(double omega) const {
      MatrixXd both(2 * A.rows(), A.cols());
      both << omega * A, B;
      return triangular_factor(both);
    }
  };
  Family after(double h, double omega) {
    Family family;
    flow_->step(x_, h, family.x, error_);
    auto [A, B] = flow_->coordinates(family.x);
    family.A = std::move(A);
    family.B = std::move(B);
    family.angles = lagrangian_angles(family.A, family.B, omega);
    return family;
  }

  /// Returns how many angles have passed a multiple of π since x_; −1 where they have moved too
  /// far.
  int crossed(const Family& later) const {
    constexpr double farthest = 1.4;
    const double moved = later.angles.sum() - angles_.sum(), count = std::round(-moved / pi);
    if (!(std::abs(moved + count * pi) <= farthest)) return -1;
    return static_cast<int>(count);
  }

  /// Returns the time after x_, at most h, at which the angle `index` of those that cross does so.
  double locate(double h, double omega, int count, int index) {
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

  Crossing crossing(double at, int multiplicity) {
    const double omega = 1 / (length_ + at);
    const Family family = after(at, omega);
    const Index d = E_.cols();
    // In orthonormal columns of (ωA; B) the singular values of ωA are the sines of the angles.
    const MatrixXd R = family.triangle(omega);
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
  void take(Family&& next, double h, double omega) {
    const MatrixXd R = next.triangle(omega);
    x_ = std::move(next.x);
    auto fields = flow_->fields(x_);
    fields = R.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(MatrixXd(fields));
    to_start_ = R.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(to_start_).eval();
    to_start_ /= to_start_.cwiseAbs().maxCoeff();
    length_ += h;
  }

  std::unique_ptr<JacobiFlow> flow_;
  MatrixXd E_;  ///< the basis at the start
  JacobiFlow::State x_, error_;
  VectorXd angles_;    ///< at x_, for the ω of the step
  MatrixXd to_start_;  ///< columns of x_ are those of the fields of E_ times this
  double length_ = 0, next_ = 0;
};

std::optional<ConnectRefusal> refused(const GeodesicRay& ray) {
  using refusal::Invalid;
  const Index n = ray.Q.rows(), N = ray.Q.cols();
  if (n < 1 || n > N || N < 2)
    return Invalid{"Q", shape(ray.Q), "must have 1 <= n <= N rows of N >= 2 numbers"};
  if (auto fault = metric_fault(ray.inertia, n, N)) return fault;
  if (const Index d = n * N - n * (n + 1) / 2; d > GeodesicRay::most_degrees)
    return Invalid{"Q", shape(ray.Q),
                   "must have at most " + std::to_string(GeodesicRay::most_degrees) +
                       " degrees of freedom, nN - n(n + 1)/2, and has " + std::to_string(d)};
  if (ray.Qdot.rows() != n || ray.Qdot.cols() != N)
    return Invalid{"Qdot", shape(ray.Qdot), "must have the shape of Q, " + shape(ray.Q)};
  if (!ray.Qdot.allFinite()) return Invalid{"Qdot", "not finite", "must be finite"};
  if (!(std::isfinite(ray.time) && ray.time > 0))
    return Invalid{"time", to_text(ray.time), "must be positive and finite"};
  const double defect =
      ray.Q.allFinite() ? orthogonality_defect(ray.Q) : std::numeric_limits<double>::infinity();
  if (!(defect <= Scene::frame_tolerance)) return refusal::NotOrthonormal{"Q", defect};
  const double size = ray.Qdot.cwiseAbs().maxCoeff();
  if (size == 0) return {};
  const MatrixXd half = ray.Qdot / size * ray.Q.transpose();
  const double normal = (half + half.transpose()).cwiseAbs().maxCoeff();
  if (!(normal <= Scene::frame_tolerance))
    return Invalid{"Qdot", "max |Qdot Q^T + Q Qdot^T| / max |Qdot| = " + to_text(normal),
                   "must be tangent: at most " + to_text(Scene::frame_tolerance)};
  return {};
}

/// Moves `search` up to `limit`, and takes over what it finds.
void follow(ConjugateSearch& search, double limit, double speed, FoundConjugatePoints& found) {
  constexpr double at_the_end = 1e-10;
  std::vector<Crossing> crossings;
  while (search.length() < limit) {
    if (!search.advance(limit * (1 + 10 * at_the_end), crossings)) {
      found.status.outcome = Outcome::solver_stalled;
      return;
    }
    for (Crossing& one : crossings) {
      if (one.length > limit * (1 + at_the_end)) continue;
      ConjugatePoint point{one.length / speed, one.multiplicity, {}, one.gap};
      for (Index k = 0; k < one.multiplicity; ++k) point.kernel.emplace_back(one.kernel.col(k));
      found.points.push_back(std::move(point));
    }
    crossings.clear();
    found.until = std::min(search.length(), limit) / speed;
    if (found.points.size() >= GeodesicRay::most_points) {
      found.status.outcome = Outcome::solver_stalled;
      return;
    }
  }
}

}  // namespace

std::expected<FoundConjugatePoints, ConnectRefusal> conjugate_points(const GeodesicRay& ray) {
  if (const auto refusal = refused(ray)) return std::unexpected(*refusal);
  const double scale =
      std::exp2(2 * std::floor(std::ilogb(ray.inertia.cwiseAbs().maxCoeff()) / 2.0));
  const VectorXd lambda = ray.inertia / scale;  // of the order of 1
  const MatrixXd Q = repaired(ray.Q);
  FoundConjugatePoints found;
  const double size = ray.Qdot.cwiseAbs().maxCoeff();
  if (size == 0) {
    found.until = ray.time;
    return found;
  }
  const MatrixXd half = ray.Qdot / size * Q.transpose(),
                 V = ray.Qdot / size - (half + half.transpose()) / 2 * Q;
  const double norm = std::sqrt((V.cwiseAbs2() * lambda).sum()), length = norm * (size * ray.time);
  if (!std::isfinite(length))
    return std::unexpected(refusal::Invalid{"time", to_text(ray.time), "is too long for Qdot"});
  const StopScope scope(ray.stop, ray.most_work);
  try {
    ConjugateSearch search(lambda, Q, V / norm);
    follow(search, length, norm * size, found);
    if (found.status.reached()) found.until = ray.time;
  } catch (const Stopped&) {
    if (!ray.stop.stop_requested() && !scope.used_up()) throw;
    found.status.outcome = ray.stop.stop_requested() ? Outcome::cancelled : Outcome::solver_stalled;
  }
  const Index n = Q.rows(), N = Q.cols();
  for (ConjugatePoint& point : found.points)
    for (MatrixXd& column : point.kernel)
      column = (column.reshaped(n, N) / std::sqrt(scale)).eval();
  return found;
}

double injectivity_bound(const VectorXd& inertia, Index n) {
  VectorXd l = inertia;
  std::sort(l.begin(), l.end());
  const Index N = l.size();
  const double least = l(0), largest = l(N - 1);
  if (!(least > 0)) return 0;
  if (n == N) return pi * (l(0) + l(1)) / std::sqrt(2 * largest);
  const double bound = pi * (least / std::sqrt(largest));
  const bool pinched = N > 2 && 4 * (least / largest) * (least / largest) * (l(1) / l(N - 2)) >= 1;
  if (n == 1 && N > 2 && (N % 2 == 1 || pinched))
    return std::max(bound, pi * std::sqrt(least * (l(1) / largest)));
  return bound;
}

}  // namespace stiefel
