#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "engine/dense/anderson.h"
#include "engine/dense/continuation.h"
#include "engine/dense/decompositions.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "engine/frame/geodesics/geodesic_series.h"
#include "engine/frame/geodesics/relaxation.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

constexpr double accurate = 1e-12;  ///< the residual to which velocities are refined
constexpr double coarse = 1e-3, fine = 1e-5, rough = 0.03;
constexpr int most_direct = 100, most_refined = 40;
constexpr double unlimited = Relaxation::largest_shift;

/// A path on pieces of polynomials of degree 8, which are halved where they do not resolve it, and
/// its relaxation.
class Track {
 public:
  static constexpr int degree = 8, most_pieces = 16;
  static constexpr double defect = 1e-3;  ///< of a path that is resolved
  static Nodes nodes(int count) { return pieces(VectorXd::LinSpaced(count + 1, 0, 1), degree); }

  Track(const Posed& p, const Nodes& nodes, const Path& path) : p_(p), nodes_(nodes) {
    start(p.lambda, path);
  }

  Relaxation& relaxation() { return *relaxation_; }
  Path at(const Nodes& other) const { return moved(relaxation_->path(), nodes_, other); }

  /// Halves pieces with a defect above `tolerance` and relaxes the path, until there are none.
  /// Returns false where that takes too many pieces or equations, or a shift above `shift`, or the
  /// path does not converge.
  bool resolve(double tolerance, double shift) {
    for (;;) {
      const VectorXd found = defects(relaxation_->path(), nodes_), &breaks = nodes_.breaks;
      if (!(found.maxCoeff() > tolerance)) return true;
      std::vector<double> halved = {0};
      for (Index i = 0; i < found.size(); ++i) {
        if (found(i) > tolerance) halved.push_back((breaks(i) + breaks(i + 1)) / 2);
        halved.push_back(breaks(i + 1));
      }
      const Index count = std::ssize(halved) - 1, n = p_.Q_0.rows();
      const Index equations = (count * degree - 1) * n * (n + 1) / 2;
      if (count > most_pieces || equations > Relaxation::most_dense) return false;
      const Nodes finer = pieces(VectorXd::Map(halved.data(), count + 1), degree);
      const Path path = at(finer);
      nodes_ = finer;
      start(relaxation_->inertia(), path);
      if (!relaxation_->relax(coarse, most_direct, shift)) return false;
    }
  }

  /// Follows the path over powers Λ^s to a wide Λ by Newton steps without shifts, from the root of
  /// Λ of as many decades as Λ spreads over; at strides below 1/32 to any minimum near by. Returns
  /// whether the path is at Λ.
  bool follow_powers();

  /// Corrects the velocity of the path until its geodesic ends at Q_T, and halves pieces where that
  /// does not converge; gives up where that takes shifts above `shift`.
  Velocity velocity(double shift);

 private:
  void start(const VectorXd& lambda, const Path& path) {
    relaxation_ = std::make_unique<Relaxation>(lambda, p_.Q_0, p_.Q_T, nodes_);
    relaxation_->set_path(path);
  }

  const Posed& p_;
  Nodes nodes_;
  std::unique_ptr<Relaxation> relaxation_;
};

/// Returns the frames nearest to a + factor (a − b).
Path extrapolated(const Path& a, const Path& b, double factor) {
  Path out = a;
  for (std::size_t k = 1; k + 1 < a.size(); ++k) {
    stop_point(connect_work::frame(a[0].rows(), a[0].cols()));
    out[k] = polar(a[k] + factor * (a[k] - b[k]));
  }
  return out;
}

bool Track::follow_powers() {
  constexpr double least_stride = 1.0 / 32, longest = std::numeric_limits<double>::infinity();
  constexpr int most_near = 8;
  const VectorXd& lambda = p_.lambda;
  const auto power = [&](double s) { return s < 1 ? VectorXd(lambda.array().pow(s)) : lambda; };
  const double decades = std::log10(lambda.maxCoeff() / lambda.minCoeff());
  bool resolved = true;
  double now = 1;
  for (int k = static_cast<int>(std::ceil(decades - 0.5)); k > 1 && resolved; --k) {
    relaxation_->set_inertia(power(now = 1.0 / k));
    (void)relaxation_->relax(rough);
    resolved = resolve(defect, unlimited);
  }
  if (now == 1) return relaxation_->relax(coarse) && resolve(defect, unlimited);
  double earlier = 0;
  Path before;  // at `earlier`, where the nodes are still the same
  const auto moved_to = [&](double s) {
    if (!resolved) return false;
    const double tolerance = s < 1 ? rough : coarse;
    Path path = relaxation_->path();
    relaxation_->set_inertia(power(s));
    if (before.size() == path.size())
      relaxation_->set_path(extrapolated(path, before, (s - now) / (now - earlier)));
    bool found = relaxation_->relax(tolerance, most_near, 0);
    if (!found) {
      relaxation_->set_path(path);
      found = s - now <= least_stride && relaxation_->relax(tolerance);
    }
    if (found) {
      earlier = std::exchange(now, s);
      before = std::move(path);
      return resolved = resolve(defect, unlimited);
    }
    relaxation_->set_inertia(power(now));
    relaxation_->set_path(path);
    return false;
  };
  return continuation(1, moved_to, longest, now, least_stride) == 1;
}

Velocity Track::velocity(double shift) {
  constexpr double least_defect = 1e-10;
  Velocity best;
  for (;;) {
    Velocity found = corrected(p_, relaxation_->velocity(), relaxation_->action(),
                               [&](const MatrixXd& end) { return relaxation_->response(end); });
    if (found.residual < best.residual) best = std::move(found);
    const double largest = defects(relaxation_->path(), nodes_).maxCoeff();
    if (best.residual <= accurate || !(largest > least_defect) || !resolve(largest / 10, shift))
      return best;
    (void)relaxation_->relax(fine);
  }
}

/// A path that a start led to, at the first nodes. Only the shortest so far keeps its track.
struct Trial {
  std::unique_ptr<Track> track;
  int start;
  Path path;
  double action;
  bool tried = false;
};

constexpr double same_path = 1e-2;  ///< the distance of relaxed paths that are one

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
    if (!settled || std::ranges::any_of(
                        seen, [&](const Path& other) { return distance(other, path) < same_path; }))
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

}  // namespace

Velocity corrected(const Posed& p, MatrixXd V, double action,
                   const std::function<MatrixXd(const MatrixXd&)>& response) {
  constexpr int most = 16;
  constexpr double rounding = 3e-15, nearly = 1e-13, strayed = 0.02;
  Velocity best;
  VectorXd x = V.reshaped();
  Anderson accelerate(x.size(), 1, 6);
  double start = 0;
  int idle = 0;
  for (int k = 0; k < most && idle < 3; ++k) {
    V.reshaped() = x;
    const auto end = geodesic_end(p.lambda, p.Q_0, V);
    if (!end) break;
    const MatrixXd miss = end->Q - p.Q_T;
    const double residual = miss.cwiseAbs().maxCoeff();
    if (k == 0) start = residual;
    if (!(residual <= 10 * start)) break;
    idle = residual > best.residual / 2 ? idle + 1 : 0;
    if (residual < best.residual) best = {V, residual};
    if (best.residual <= rounding || (best.residual <= nearly && idle > 0)) break;
    stop_point(connect_work::sums(20, V.rows(), V.cols()));
    accelerate(x, response(-miss).reshaped());
  }
  const bool near =
      best.V.size() > 0 && energy(p.lambda, best.V) <= (1 + strayed) * action + 1e-300;
  return near ? best : Velocity();
}

void ShortestSoFar::take(const Posed& p, const Velocity& velocity, double action, int start,
                         Found& best) {
  if (velocity.residual > TwoPointProblem::joined) {
    if (best.V.size() == 0) best.residual = std::min(best.residual, velocity.residual);
    least_missed = std::min(least_missed, action);
    return;
  }
  const double E = energy(p.lambda, velocity.V);
  if (!(E < least)) return;
  least = E;
  best.V = velocity.V;
  best.start = start;
  best.residual = velocity.residual;
}

Shortest ShortestSoFar::verdict(bool complete) const {
  if (least_missed < (1 - 1e-3) * least && std::isfinite(least)) return Shortest::no;
  return complete ? Shortest::none_shorter_found : Shortest::unknown;
}

void by_multipliers(const Posed& p, const TwoPointProblem& problem, Found& best) {
  constexpr double most_of_doubtful = 2e6, very_wide = 30;
  constexpr int further = 4;
  const Nodes nodes = Track::nodes(p.lambda.maxCoeff() > very_wide * p.lambda.minCoeff() ? 2 : 1);
  std::vector<Trial> trials;
  int start = 0;
  bool complete = true, doubtful = is_wide(p.lambda);
  ShortestSoFar shortest;
  const auto keep = [&](Trial& trial) {
    if (std::exchange(trial.tried, true)) return;
    const bool relaxed =
        trial.track ||
        (trial.track = std::make_unique<Track>(p, nodes, trial.path))->relaxation().relax(coarse);
    const Velocity velocity =
        relaxed ? trial.track->velocity(trial.start > 0 && is_wide(p.lambda) ? 0 : unlimited)
                : Velocity();
    shortest.take(p, velocity, trial.action, trial.start, best);
  };
  const auto relax = [&](const std::vector<Path>& paths) {
    for (; start < static_cast<int>(paths.size()); ++start) {
      const Path& path = paths[static_cast<std::size_t>(start)];
      if (path.empty()) continue;
      auto track = std::make_unique<Track>(p, nodes, path);
      bool settled = start == 0 && is_wide(p.lambda) && track->follow_powers();
      if (!settled) {
        track = std::make_unique<Track>(p, nodes, track->at(nodes));
        settled = track->relaxation().relax(coarse, start == 0 ? most_direct : most_refined);
      }
      complete = complete && settled;
      doubtful = doubtful || !settled || track->relaxation().shifted();
      Trial trial{nullptr, start, track->at(nodes), track->relaxation().action()};
      if (!settled || std::ranges::any_of(trials, [&](const Trial& t) {
            return distance(t.path, trial.path) < same_path;
          }))
        continue;
      if (std::ranges::all_of(trials, [&](const Trial& t) { return trial.action < t.action; })) {
        for (Trial& other : trials) other.track.reset();
        trial.track = std::move(track);
      }
      if (trials.empty()) keep(trial);
      trials.push_back(std::move(trial));
      best.distinct = static_cast<int>(trials.size());
    }
  };
  const bool wide = is_wide(p.lambda) && problem.restarts > 0;
  relax(starts(p.Q_0, p.Q_T, nodes.times, problem.restarts, problem.seed, wide));
  if (doubtful && problem.restarts == 0 && work(p) <= most_of_doubtful) {
    const Nodes fewer = is_wide(p.lambda) ? pieces(VectorXd::LinSpaced(2, 0, 1), 4) : nodes;
    std::vector<Path> more =
        starts(p.Q_0, p.Q_T, fewer.times, further, problem.seed, is_wide(p.lambda));
    if (is_wide(p.lambda)) {
      if (!trials.empty()) more[0] = moved(trials[0].path, nodes, fewer);
      complete = thin(p, fewer, nodes, more) && complete;
    }
    relax(more);
  }
  std::ranges::stable_sort(trials, {}, &Trial::action);
  for (Trial& trial : trials) {
    if (trial.action > margin * shortest.least) break;
    keep(trial);
  }
  best.shortest = shortest.verdict(complete);
}

}  // namespace stiefel
