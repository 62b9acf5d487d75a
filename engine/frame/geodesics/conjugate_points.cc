#include "stiefel/conjugate_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/dense/orthogonal.h"
#include "engine/frame/geodesics/conjugate_search.h"
#include "engine/frame/geodesics/metric.h"
#include "engine/numbers/to_text.h"
#include "stiefel/scene.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::string shape(const MatrixXd& Q) {
  return std::to_string(Q.rows()) + " x " + std::to_string(Q.cols());
}

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
  using std::numbers::pi;
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
