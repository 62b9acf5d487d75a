#include "stiefel/connect.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "engine/numbers/to_text.h"
#include "engine/linalg/lie/orthogonal.h"
#include "engine/linalg/matrix_equations/lu.h"
#include "engine/frames/geodesics/closed_geodesic.h"
#include "engine/frames/geodesics/path.h"
#include "engine/frames/geodesics/shoot.h"
#include "engine/frames/geodesics/starts.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool is_body(const MatrixXd& Q) { return Q.rows() == Q.cols(); }

/// The problem scaled to the time 1, with repaired frames and Λ of the order of 1.
struct Posed {
  VectorXd lambda;
  double scale;  ///< Λ = scale · lambda, a power of 2
  MatrixXd Q_0, Q_T;

  bool wide() const { return lambda.maxCoeff() > 10 * lambda.minCoeff(); }
};

double defect(const MatrixXd& Q) {
  return Q.allFinite() ? orthogonality_defect(Q) : std::numeric_limits<double>::infinity();
}

std::optional<ConnectRefusal> refused(const TwoPointProblem& p) {
  const auto invalid = [](std::string field, std::string value, std::string rule) {
    return ConnectRefusal(refusal::Invalid{std::move(field), std::move(value), std::move(rule)});
  };
  const auto shape = [](const MatrixXd& Q) {
    return std::to_string(Q.rows()) + " x " + std::to_string(Q.cols());
  };
  const Index n = p.Q_0.rows(), N = p.Q_0.cols();
  if (n < 1 || n > N || N < 2)
    return invalid("Q_0", shape(p.Q_0), "must have 1 <= n <= N rows of N >= 2 numbers");
  if (p.Q_T.rows() != n || p.Q_T.cols() != N)
    return invalid("Q_T", shape(p.Q_T), "must have the shape of Q_0, " + shape(p.Q_0));
  if (p.inertia.size() != N)
    return invalid("inertia", std::to_string(p.inertia.size()) + " numbers",
                   "must have " + std::to_string(N));
  for (Index k = 0; k < N; ++k)
    if (!std::isfinite(p.inertia(k)))
      return invalid("inertia[" + std::to_string(k) + "]", to_text(p.inertia(k)), "must be finite");
  VectorXd sorted = p.inertia;
  std::sort(sorted.begin(), sorted.end());
  if (n < N && !(sorted(0) > 0))
    return invalid("inertia", "smallest " + to_text(sorted(0)), "must be positive for n < N");
  if (n == N && !(sorted(0) + sorted(1) > 0))
    return invalid("inertia", "the two smallest add up to " + to_text(sorted(0) + sorted(1)),
                   "every two must have a positive sum");
  if (!(std::isfinite(p.time) && p.time > 0))
    return invalid("time", to_text(p.time), "must be positive and finite");
  if (p.restarts < 0)
    return invalid("restarts", std::to_string(p.restarts), "must not be negative");
  for (const auto& [field, Q] : {std::pair("Q_0", &p.Q_0), std::pair("Q_T", &p.Q_T)})
    if (const double error = defect(*Q); !(error <= Scene::frame_tolerance))
      return refusal::NotOrthonormal{field, error};
  if (n == N) {
    const int first = p.Q_0.determinant() < 0 ? -1 : 1, last = p.Q_T.determinant() < 0 ? -1 : 1;
    if (first != last) return refusal::UnequalDeterminants{first, last};
  }
  return {};
}

/// Refuses a path of K steps whose relaxation would need too much memory: five d × d blocks and a
/// basis of d directions for every inner frame, for all starts at once.
std::optional<ConnectRefusal> too_large(const TwoPointProblem& p, int K) {
  const double nN = static_cast<double>(p.Q_0.size()), n = static_cast<double>(p.Q_0.rows());
  const double d = nN - n * (n + 1) / 2;
  const double each = 8 * (5 * d * d + nN * d + nN * (p.restarts + 3.0));
  if (each * K <= static_cast<double>(TwoPointProblem::most_bytes)) return {};
  const auto most = static_cast<int>(static_cast<double>(TwoPointProblem::most_bytes) / each);
  return refusal::Invalid{"steps", std::to_string(K),
                          "must be at most " + std::to_string(most) + " for frames of " +
                              std::to_string(p.Q_0.size()) + " numbers and " +
                              std::to_string(p.restarts) + " restarts: a step takes " +
                              std::to_string(static_cast<int>(each / 1024)) + " KiB of " +
                              std::to_string(TwoPointProblem::most_bytes >> 20) + " MiB"};
}

Posed posed(const TwoPointProblem& p) {
  const double scale = std::exp2(std::ilogb(p.inertia.cwiseAbs().maxCoeff()));
  return {p.inertia / scale, scale, repaired(p.Q_0), repaired(p.Q_T)};
}

struct Candidate {
  Path path;
  double action;
  int start;
  bool settled;  ///< whether the path is a local minimum; else relaxing it took too long
};

/// Returns each distinct path once, settled before not and with its earliest start, sorted by the
/// action.
std::vector<Candidate> distinct(std::vector<Candidate> all) {
  constexpr double same = 1e-3;
  std::ranges::sort(all, {}, [](const Candidate& c) { return std::pair(!c.settled, c.start); });
  std::vector<Candidate> result;
  for (Candidate& candidate : all)
    if (std::ranges::none_of(
            result, [&](const Candidate& c) { return distance(c.path, candidate.path) < same; }))
      result.push_back(std::move(candidate));
  std::ranges::stable_sort(result, {}, &Candidate::action);
  return result;
}

/// Returns the paths that the starts lead to.
std::vector<Candidate> relaxed(const Posed& posed, const TwoPointProblem& problem, int K,
                               double tolerance) {
  std::vector<Candidate> all;
  int start = 0;
  for (Path& path : starts(posed.Q_0, posed.Q_T, K, problem.restarts, problem.seed, posed.wide())) {
    const bool settled = relax(posed.lambda, path, tolerance, problem.stop);
    const double reached = action(posed.lambda, path);
    all.push_back({std::move(path), reached, start++, settled});
  }
  return distinct(std::move(all));
}

void refine(const VectorXd& lambda, Candidate& c, double tolerance, const std::stop_token& stop) {
  c.path = refined(c.path);
  c.settled = relax(lambda, c.path, tolerance, stop);
  c.action = action(lambda, c.path);
}

double energy(const VectorXd& lambda, const MatrixXd& V) {
  return (V.cwiseAbs2() * lambda).sum() / 2;
}

/// Shoots from paths of doubled K until the geodesic near the path is found.
Shot solved(const Posed& p, Candidate& c, const std::stop_token& stop) {
  constexpr std::size_t finest = 1024;
  constexpr double strayed = 0.02;
  Shot best;
  for (;;) {
    const Shot shot = shoot(p.lambda, p.Q_0, p.Q_T, initial_velocity(p.lambda, c.path), stop);
    const bool near = energy(p.lambda, shot.V) <= (1 + strayed) * c.action + 1e-300;
    if (near && shot.residual < best.residual) best = shot;
    if (best.residual <= TwoPointProblem::joined || 2 * c.path.size() > finest) return best;
    refine(p.lambda, c, 1e-8, stop);
    if (!c.settled) return best;
  }
}

/// What the search for a geodesic found, at the time scale 1.
struct Found {
  MatrixXd V;  ///< Q̇(0); empty where there is none to the residual `joined`
  Shortest shortest = Shortest::none_shorter_found;
  int distinct = 0, start = 0;
  double residual = std::numeric_limits<double>::infinity();  ///< the best where V is empty
};

/// Runs `search` within the work and the stop token of the problem.
template <class Search>
auto within(const TwoPointProblem& problem, Search&& search) -> decltype(search()) {
  const StopScope scope(problem.stop, problem.most_work);
  try {
    return search();
  } catch (const Stopped&) {
    if (problem.stop.stop_requested()) return std::unexpected(refusal::Cancelled{});
    if (!scope.used_up()) throw;
    return std::unexpected(refusal::NotConverged{std::numeric_limits<double>::infinity()});
  }
}

Found searched(const Posed& p, const TwoPointProblem& problem) {
  constexpr double coarse = 1e-6, fine = 1e-9, margin = 1.1;
  const bool wide = p.wide();

  std::vector<Candidate> all = relaxed(p, problem, wide ? 32 : 16, coarse);
  for (Candidate& c : all)
    for (int K = wide ? 64 : 32; K <= (wide ? 128 : 64); K *= 2)
      refine(p.lambda, c, fine, problem.stop);
  all = distinct(std::move(all));

  Found best;
  bool complete = true;
  double least = std::numeric_limits<double>::infinity(), least_missed = least;
  for (Candidate& c : all) {
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
  const double slack = 1 + 1e-12;
  if (least_missed < (1 - 1e-3) * least)
    best.shortest = Shortest::no;
  else if (is_round(p.lambda) && best.V.norm() <= slack * std::numbers::pi)
    best.shortest = Shortest::yes;
  else if (!complete)
    best.shortest = Shortest::unknown;
  return best;
}

Found found(const Posed& p, const TwoPointProblem& problem) {
  if (p.Q_0 == p.Q_T) return {MatrixXd::Zero(p.Q_0.rows(), p.Q_0.cols()), Shortest::yes, 1, 0};
  if (auto closed = closed_geodesic(p.lambda, p.Q_0, p.Q_T))
    return {std::move(closed->V), Shortest::yes, closed->distinct, closed->start};
  return searched(p, problem);
}

std::expected<Geodesic, ConnectRefusal> search(const TwoPointProblem& problem) {
  const Posed p = posed(problem);
  Found best = found(p, problem);
  if (problem.stop.stop_requested()) return std::unexpected(refusal::Cancelled{});
  if (best.V.size() == 0) return std::unexpected(refusal::NotConverged{best.residual});

  Geodesic answer;
  answer.shortest = best.shortest;
  answer.distinct = best.distinct;
  answer.start = best.start;
  answer.Q = p.Q_0;
  answer.Qdot = best.V / problem.time;
  answer.S = answer.Qdot * problem.inertia.asDiagonal();
  if (is_body(p.Q_0)) answer.M = momentum(problem.inertia, p.Q_0, answer.Qdot);
  answer.energy = energy(problem.inertia, answer.Qdot);
  answer.residual =
      miss(problem.inertia, p.Q_0, is_body(p.Q_0) ? answer.M : answer.S, p.Q_T, problem.time);
  if (!(answer.residual <= TwoPointProblem::joined))
    return std::unexpected(refusal::NotConverged{answer.residual});
  return answer;
}

std::expected<DiscreteGeodesic, ConnectRefusal> search(const TwoPointProblem& problem, int K) {
  constexpr double tolerance = 1e-10, stationary = 1e-12;
  const Posed p = posed(problem);
  std::vector<Candidate> all = relaxed(p, problem, K, tolerance);
  std::erase_if(all, [](const Candidate& c) { return !c.settled; });
  if (problem.stop.stop_requested()) return std::unexpected(refusal::Cancelled{});
  if (all.empty())
    return std::unexpected(refusal::NotConverged{std::numeric_limits<double>::infinity()});

  const Candidate& best = all.front();
  const double residual = largest_gradient(p.lambda, best.path);
  if (!(residual <= stationary)) return std::unexpected(refusal::NotConverged{residual});
  DiscreteGeodesic result;
  result.Q = best.path;
  const MatrixXd V = initial_velocity(p.lambda, best.path) / problem.time;
  result.S = V * problem.inertia.asDiagonal();
  if (is_body(p.Q_0)) result.M = momentum(problem.inertia, p.Q_0, V);
  result.energy = best.action * p.scale / (problem.time * problem.time);
  result.residual = residual;
  result.distinct = static_cast<int>(all.size());
  result.start = best.start;
  return result;
}

}  // namespace

std::expected<Geodesic, ConnectRefusal> connect(const TwoPointProblem& problem) {
  if (const auto refusal = refused(problem)) return std::unexpected(*refusal);
  return within(problem, [&] { return search(problem); });
}

std::expected<DiscreteGeodesic, ConnectRefusal> connect(const TwoPointProblem& problem, int K) {
  if (const auto refusal = refused(problem)) return std::unexpected(*refusal);
  if (K < 1) return std::unexpected(refusal::Invalid{"K", std::to_string(K), "must be at least 1"});
  if (const auto refusal = too_large(problem, K)) return std::unexpected(*refusal);
  return within(problem, [&] { return search(problem, K); });
}

}  // namespace stiefel
