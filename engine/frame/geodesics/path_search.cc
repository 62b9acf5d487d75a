#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "engine/frame/geodesics/relaxation.h"
#include "engine/frame/geodesics/shoot.h"
#include "engine/frame/geodesics/starts.h"

namespace stiefel {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Returns each distinct path once, settled before not and with its earliest start, sorted by the
/// action.
std::vector<RelaxedPath> distinct(std::vector<RelaxedPath> all) {
  constexpr double same = 1e-3;
  std::ranges::sort(all, {}, [](const RelaxedPath& c) { return std::pair(!c.settled, c.start); });
  std::vector<RelaxedPath> result;
  for (RelaxedPath& candidate : all)
    if (std::ranges::none_of(
            result, [&](const RelaxedPath& c) { return distance(c.path, candidate.path) < same; }))
      result.push_back(std::move(candidate));
  std::ranges::stable_sort(result, {}, &RelaxedPath::action);
  return result;
}

void refine(const VectorXd& lambda, RelaxedPath& c, double tolerance, const std::stop_token& stop) {
  c.path = refined(c.path);
  c.settled = relax(lambda, c.path, tolerance, stop);
  c.action = action(lambda, c.path);
}

double degrees(const Posed& p) { return connect_work::degrees(p.Q_0.rows(), p.Q_0.cols()); }

/// Shoots from paths of doubled K until the geodesic near the path is found.
Shot solved(const Posed& p, RelaxedPath& c, const std::stop_token& stop) {
  const int finest = TwoPointProblem::most_path_steps(degrees(p));
  Shot best;
  for (;;) {
    const Shot shot = shoot(p.lambda, p.Q_0, p.Q_T, initial_velocity(p.lambda, c.path), stop);
    const bool near = energy(p.lambda, shot.V) <= (1 + strayed) * c.action + 1e-300;
    if (near && shot.residual < best.residual) best = shot;
    if (best.residual <= TwoPointProblem::joined || 2 * std::ssize(c.path) - 2 > finest)
      return best;
    refine(p.lambda, c, 1e-8, stop);
    if (!c.settled) return best;
  }
}

}  // namespace

std::vector<RelaxedPath> relaxed(const Posed& posed, const TwoPointProblem& problem, int K,
                                 double tolerance) {
  const VectorXd times = VectorXd::LinSpaced(K + 1, 0, 1);
  const bool dense =
      degrees(posed) <= most_dense_degrees || !(posed.lambda.minCoeff() > 0) || K == 1;
  std::optional<Relaxation> relaxation;
  if (!dense) relaxation.emplace(posed.lambda, posed.Q_0, posed.Q_T, equally_spaced(K));
  std::vector<RelaxedPath> all;
  int start = 0;
  for (Path& path :
       starts(posed.Q_0, posed.Q_T, times, problem.restarts, problem.seed, posed.wide())) {
    bool settled = false;
    if (dense) {
      settled = K == 1 || relax(posed.lambda, path, tolerance, problem.stop);
    } else {
      relaxation->set_path(path);
      settled = relaxation->relax(tolerance);
      path = relaxation->path();
    }
    const double reached = action(posed.lambda, path);
    all.push_back({std::move(path), reached, start++, settled});
  }
  return distinct(std::move(all));
}

void by_paths(const Posed& p, const TwoPointProblem& problem, Found& best) {
  constexpr double coarse = 1e-6, fine = 1e-9, margin = 1.1;
  const bool wide = p.wide();

  std::vector<RelaxedPath> all = relaxed(p, problem, wide ? 32 : 16, coarse);
  for (RelaxedPath& c : all)
    for (int K = wide ? 64 : 32; K <= (wide ? 128 : 64); K *= 2)
      refine(p.lambda, c, fine, problem.stop);
  all = distinct(std::move(all));

  best = {};
  bool complete = true;
  double least = std::numeric_limits<double>::infinity(), least_missed = least;
  for (RelaxedPath& c : all) {
    best.distinct += c.settled;
    if (c.action > margin * least) {
      complete = complete && c.settled;
      continue;
    }
    const Shot shot = solved(p, c, problem.stop);
    if (shot.residual <= TwoPointProblem::joined) {
      const double E = energy(p.lambda, shot.V);
      if (E < least) best.V = shot.V, least = E, best.start = c.start;
    } else {
      complete = complete && c.settled;
      best.residual = std::min(best.residual, shot.residual);
      least_missed = std::min(least_missed, c.action);
    }
  }
  best.distinct = std::max(best.distinct, 1);
  if (least_missed < (1 - 1e-3) * least)
    best.shortest = Shortest::no;
  else if (!complete)
    best.shortest = Shortest::unknown;
}

}  // namespace stiefel
