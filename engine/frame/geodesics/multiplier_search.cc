#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "engine/frame/geodesics/relaxation.h"
#include "engine/frame/geodesics/shoot.h"
#include "engine/frame/geodesics/starts.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The problem with at most 2n columns of each λ: a geodesic's columns of one λ stay in the span of
/// those of Q_0 and Q_T.
class Spans {
 public:
  explicit Spans(const Posed& p) : whole_(p), reduced_(p) {
    const Index n = p.Q_0.rows(), N = p.Q_0.cols();
    std::vector<Index> order(static_cast<std::size_t>(N));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](Index j) { return p.lambda(j); });
    Index columns = 0;
    for (auto from = order.begin(); from != order.end();) {
      const double lambda = p.lambda(*from);
      const auto to =
          std::find_if(from, order.end(), [&](Index j) { return p.lambda(j) != lambda; });
      parts_.push_back({{from, to}, {}});
      columns += std::min<Index>(to - from, 2 * n);
      from = to;
    }
    if (columns == N) {
      parts_.clear();
      return;
    }
    reduced_.lambda.resize(columns);
    reduced_.Q_0.resize(n, columns);
    reduced_.Q_T.resize(n, columns);
    Index at = 0;
    for (Part& part : parts_) {
      const Index count = static_cast<Index>(part.columns.size()), kept = std::min(count, 2 * n);
      stop_point(2 * connect_work::frame(n, count));
      const MatrixXd Q_0 = part.of(p.Q_0), Q_T = part.of(p.Q_T);
      part.basis.setIdentity(count, count);
      if (kept < count) {
        MatrixXd both(count, 2 * n);
        both << Q_0.transpose(), Q_T.transpose();
        part.basis = orthonormal_columns(both, kept);
      }
      reduced_.lambda.segment(at, kept).setConstant(p.lambda(part.columns[0]));
      reduced_.Q_0.middleCols(at, kept) = Q_0 * part.basis;
      reduced_.Q_T.middleCols(at, kept) = Q_T * part.basis;
      at += kept;
    }
  }

  const Posed& reduced() const { return reduced_; }
  MatrixXd lifted(const MatrixXd& V) const {
    if (parts_.empty()) return V;
    MatrixXd out(V.rows(), whole_.Q_0.cols());
    Index at = 0;
    for (const Part& part : parts_) {
      const Index kept = part.basis.cols();
      const MatrixXd columns = V.middleCols(at, kept) * part.basis.transpose();
      for (Index k = 0; k < columns.cols(); ++k)
        out.col(part.columns[static_cast<std::size_t>(k)]) = columns.col(k);
      at += kept;
    }
    return out;
  }

 private:
  struct Part {
    std::vector<Index> columns;
    MatrixXd basis;

    /// Returns these columns of a frame.
    MatrixXd of(const MatrixXd& Q) const {
      MatrixXd out(Q.rows(), std::ssize(columns));
      for (Index k = 0; k < out.cols(); ++k)
        out.col(k) = Q.col(columns[static_cast<std::size_t>(k)]);
      return out;
    }
  };
  const Posed& whole_;
  Posed reduced_;
  std::vector<Part> parts_;
};

/// A path that a start led to. Only the shortest so far keeps its relaxation.
struct Trial {
  std::unique_ptr<Relaxation> relaxation;
  int start;
  Path path;
  double action;
  std::optional<Velocity> velocity = {};  ///< corrected
};

constexpr double accurate = 1e-12;  ///< the residual to which velocities are refined
constexpr double coarse = 1e-3, fine = 1e-5;
constexpr int most_nodes = 128, most_direct = 100, most_refined = 40;

int least_nodes(const VectorXd& lambda) {
  return lambda.maxCoeff() > 30 * lambda.minCoeff() ? 16 : 8;
}

/// Returns 2K, or 3K/2 where only these nodes have dense equations.
int more_nodes(const Posed& p, int K) {
  const Index n = p.Q_0.rows(), each = n * (n + 1) / 2;
  const bool fewer = (2 * K - 1) * each > Relaxation::most_dense &&
                     (3 * K / 2 - 1) * each <= Relaxation::most_dense;
  return fewer ? 3 * K / 2 : 2 * K;
}

/// Whether `by_powers` has eight pieces of 8 steps before it has too many equations.
bool leaves_room(const Posed& p) {
  const Index n = p.Q_0.rows();
  return 63 * n * (n + 1) / 2 <= Relaxation::most_dense;
}

/// Corrects the velocity of a trial at more and more nodes. Of a wide Λ it gives up where Newton's
/// steps need shifts: `by_powers` then takes less work than a descent.
Velocity solved(const Posed& p, const Trial& trial, int K) {
  const int most = p.wide() && leaves_room(p) ? 2 * K : most_nodes;
  int further = p.wide() ? 1 : 0;  // refinements of a velocity that joins, but is not accurate
  Velocity best;
  std::unique_ptr<Relaxation> finer;
  Nodes nodes = lobatto(K);
  if (!trial.relaxation) {
    finer = std::make_unique<Relaxation>(p.lambda, p.Q_0, p.Q_T, nodes);
    finer->set_path(trial.path);
    if (!finer->relax(coarse)) return best;
  }
  const Relaxation* now = trial.relaxation ? trial.relaxation.get() : finer.get();
  for (;;) {
    Velocity found = corrected(p, *now);
    if (found.residual < best.residual) best = std::move(found);
    const bool joins = best.residual <= TwoPointProblem::joined;
    if (best.residual <= accurate || (joins && further-- == 0) || 2 * K > most) return best;
    Nodes more = lobatto(K = more_nodes(p, K));
    auto next = std::make_unique<Relaxation>(p.lambda, p.Q_0, p.Q_T, more);
    next->set_path(moved(now->path(), nodes, more));
    if (!next->relax(fine, most_refined, p.wide() ? 0 : Relaxation::largest_shift)) return best;
    finer = std::move(next);
    now = finer.get();
    nodes = std::move(more);
  }
}

constexpr double same = 1e-2;  ///< the distance of relaxed paths that are one

/// Relaxes starts with fewer nodes, where a step costs little, and moves to `nodes` those that lead
/// to other paths than the earlier ones. Leaves the others empty; returns whether all settled.
bool thin(const Posed& p, const Nodes& fewer, const Nodes& nodes, std::vector<Path>& starts) {
  Relaxation relaxation(p.lambda, p.Q_0, p.Q_T, fewer);
  std::vector<Path> seen;
  bool complete = true;
  for (Path& start : starts) {
    relaxation.set_path(std::exchange(start, {}));
    const bool settled = relaxation.relax(coarse, most_refined);
    complete = complete && settled;
    Path path = relaxation.path();
    if (!settled ||
        std::ranges::any_of(seen, [&](const Path& other) { return distance(other, path) < same; }))
      continue;
    start = moved(path, fewer, nodes);
    seen.push_back(std::move(path));
  }
  return complete;
}

/// Returns the order of the work of a relaxation.
double work(const Posed& p) {
  const double n = static_cast<double>(p.Q_0.rows()), N = static_cast<double>(p.Q_0.cols());
  return n * n * n * n * (N + n * n);
}

/// Searches from K + 1 nodes on. Without restarts it takes further starts only where a direct path
/// led over a saddle, or where Λ is wide.
void search(const Spans& spans, const TwoPointProblem& problem, int K, Found& best) {
  constexpr double margin = 1.1, most_of_doubtful = 2e6;
  constexpr int further = 4;
  const Posed& p = spans.reduced();
  const Nodes nodes = lobatto(K);
  std::vector<Trial> trials;
  int start = 0;
  bool complete = true, doubtful = p.wide();
  double least = std::numeric_limits<double>::infinity();
  double& least_missed = best.least_missed = least;
  best.shortest = Shortest::none_shorter_found;
  const auto keep = [&](Trial& trial) {
    if (trial.velocity) return;
    trial.velocity = solved(p, trial, K);
    const auto& [V, residual] = *trial.velocity;
    if (residual > TwoPointProblem::joined) {
      if (best.V.size() == 0) best.residual = std::min(best.residual, residual);
      least_missed = std::min(least_missed, trial.action);
    } else if (const double E = energy(p.lambda, V); E < least) {
      least = E;
      best.V = spans.lifted(V);
      best.start = trial.start;
      best.residual = residual;
    }
  };
  const auto relax = [&](const std::vector<Path>& paths) {
    for (; start < static_cast<int>(paths.size()); ++start) {
      if (paths[static_cast<std::size_t>(start)].empty()) continue;
      auto relaxation = std::make_unique<Relaxation>(p.lambda, p.Q_0, p.Q_T, nodes);
      relaxation->set_path(paths[static_cast<std::size_t>(start)]);
      bool settled =
          start == 0 && p.wide() && follow_powers(p.lambda, relaxation, [] { return true; });
      if (!settled) {
        relaxation->set_inertia(p.lambda);
        settled = relaxation->relax(coarse, start == 0 ? most_direct : most_refined);
      }
      complete = complete && settled;
      doubtful = doubtful || !settled || relaxation->shifted();
      Trial trial{nullptr, start, relaxation->path(), relaxation->action()};
      if (!settled || std::ranges::any_of(trials, [&](const Trial& t) {
            return distance(t.path, trial.path) < same;
          }))
        continue;
      if (std::ranges::all_of(trials, [&](const Trial& t) { return trial.action < t.action; })) {
        for (Trial& other : trials) other.relaxation.reset();
        trial.relaxation = std::move(relaxation);
      }
      if (trials.empty()) keep(trial);
      trials.push_back(std::move(trial));
      best.distinct = static_cast<int>(trials.size());
    }
  };
  const bool wide = p.wide() && problem.restarts > 0;
  relax(starts(p.Q_0, p.Q_T, nodes.times, problem.restarts, problem.seed, wide));
  if (doubtful && problem.restarts == 0 && work(p) <= most_of_doubtful) {
    const Nodes fewer = p.wide() ? lobatto(std::max(K / 4, 4)) : nodes;
    std::vector<Path> more = starts(p.Q_0, p.Q_T, fewer.times, further, problem.seed, p.wide());
    if (p.wide()) {
      if (!trials.empty()) more[0] = moved(trials[0].path, nodes, fewer);
      complete = thin(p, fewer, nodes, more) && complete;
    }
    relax(more);
  }
  std::ranges::stable_sort(trials, {}, &Trial::action);
  for (Trial& trial : trials) {
    if (trial.action > margin * least) break;
    keep(trial);
  }
  if (best.V.size() > 0 && least_missed < (1 - 1e-3) * least)
    best.shortest = Shortest::no;
  else if (!complete)
    best.shortest = Shortest::unknown;
}

/// Corrects a velocity that joins, but is not accurate, with the variational equation in extended
/// precision, up to `most_dense_degrees`.
void polish(const Posed& p, const TwoPointProblem& problem, Found& best) {
  const double d = connect_work::degrees(p.Q_0.rows(), p.Q_0.cols());
  if (best.V.size() == 0 || best.residual <= accurate || d > most_dense_degrees) return;
  Shot shot = shoot(p.lambda, p.Q_0, p.Q_T, best.V, problem.stop);
  if (!(shot.residual < best.residual)) return;
  best.V = std::move(shot.V);
  best.residual = shot.residual;
}

}  // namespace

void by_multipliers(const Posed& p, const TwoPointProblem& problem, Found& best) {
  constexpr double most_unknowns = 800;  // of a search that is repeated with more nodes
  const double n = static_cast<double>(p.Q_0.rows());
  const Spans spans(p);
  const auto energy_of = [&](const Found& found) {
    return found.V.size() > 0 ? energy(p.lambda, found.V) : std::numeric_limits<double>::infinity();
  };
  Found followed;
  for (int K = least_nodes(p.lambda); K <= most_nodes / 2; K *= 2) {
    search(spans, problem, K, best);
    if (best.V.size() == 0 && p.wide() && K == least_nodes(p.lambda)) {
      const Velocity one = by_powers(spans.reduced(), problem);
      best.residual = std::min(best.residual, one.residual);
      if (one.residual <= TwoPointProblem::joined)
        followed = {spans.lifted(one.V), Shortest::unknown, 1, 0, one.residual};
      if (energy_of(followed) <= (1 + strayed) * best.least_missed) {
        followed.shortest = best.shortest;
        break;
      }
    }
    if (best.V.size() > 0 || 2 * K * n * (n + 1) / 2 > most_unknowns) break;
  }
  if (energy_of(followed) < energy_of(best)) best = std::move(followed);
  polish(p, problem, best);
}

}  // namespace stiefel
