#include <algorithm>
#include <optional>
#include <utility>

#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "engine/frame/geodesics/relaxation.h"
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

double degrees(const Posed& p) { return connect_work::degrees(p.Q_0.rows(), p.Q_0.cols()); }

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
  constexpr double accurate = 1e-12;
  const int finest = TwoPointProblem::most_path_steps(degrees(p));
  ShortestSoFar shortest;
  bool complete = true;
  for (RelaxedPath& c : relaxed(p, problem, 32, 1e-6)) {
    complete = complete && c.settled;
    best.distinct += c.settled;
    if (c.action > margin * shortest.least) continue;
    Velocity velocity;
    do {
      c.path = refined(c.path);
      if (!relax(p.lambda, c.path, 1e-8, problem.stop)) break;
      Velocity found =
          corrected(p, initial_velocity(p.lambda, c.path), action(p.lambda, c.path),
                    [&](const MatrixXd& end) { return response(p.lambda, c.path, end); });
      if (found.residual < velocity.residual) velocity = std::move(found);
    } while (velocity.residual > accurate && 2 * std::ssize(c.path) - 2 <= finest);
    shortest.take(p, velocity, c.action, c.start, best);
  }
  best.shortest = shortest.verdict(complete);
}

}  // namespace stiefel
