#include "stiefel/connect.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "engine/frames/geodesics/closed_geodesic.h"
#include "engine/frames/geodesics/geodesic_search.h"
#include "engine/frames/geodesics/geodesic_series.h"
#include "engine/frames/geodesics/path.h"
#include "engine/frames/geodesics/relaxation.h"
#include "engine/frames/geodesics/round_logarithm.h"
#include "engine/frames/geodesics/shoot.h"
#include "engine/linalg/lie/orthogonal.h"
#include "engine/linalg/matrix_equations/lu.h"
#include "engine/numbers/to_text.h"
#include "stiefel/conjugate_points.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool is_body(const MatrixXd& Q) { return Q.rows() == Q.cols(); }

double defect(const MatrixXd& Q) {
  return Q.allFinite() ? orthogonality_defect(Q) : std::numeric_limits<double>::infinity();
}

/// The defects of Q_0 and Q_T.
struct Defects {
  double Q_0, Q_T;
};

std::optional<ConnectRefusal> refused(const TwoPointProblem& p, Defects& defects) {
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
  defects = {defect(p.Q_0), defect(p.Q_T)};
  for (const auto& [field, error] : {std::pair("Q_0", defects.Q_0), std::pair("Q_T", defects.Q_T)})
    if (!(error <= Scene::frame_tolerance)) return refusal::NotOrthonormal{field, error};
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

/// Returns the bytes of a search by the multipliers: two sets of their equations and factors at 17
/// nodes, the paths, and a Taylor series.
double search_bytes(const TwoPointProblem& p) {
  const double n = static_cast<double>(p.Q_0.rows()), nN = static_cast<double>(p.Q_0.size());
  const double nodes = 15, unknowns = std::min(nodes * n * (n + 1) / 2,
                                               static_cast<double>(Relaxation::most_dense));
  const double starts = std::max(p.restarts, 4) + 1 + n / 2;
  return 8 * (4 * unknowns * unknowns + 8 * nodes * nodes * n * n +
              nN * ((nodes + 2) * starts + 12 * nodes + 160));
}

std::optional<ConnectRefusal> too_large(const TwoPointProblem& p) {
  const double most = static_cast<double>(TwoPointProblem::most_bytes), bytes = search_bytes(p);
  if (bytes <= most || is_round(p.inertia)) return {};
  return refusal::Invalid{
      "Q_0", std::to_string(p.Q_0.rows()) + " x " + std::to_string(p.Q_0.cols()),
      "a search with different inertias and " + std::to_string(p.restarts) +
          " restarts must take at most " + std::to_string(TwoPointProblem::most_bytes >> 20) +
          " MiB, and takes " + std::to_string(static_cast<std::int64_t>(bytes) >> 20)};
}

/// Returns what `repaired` does for a frame of a known defect.
MatrixXd repaired(const MatrixXd& Q, double defect) {
  const double rounding = 4 * static_cast<double>(Q.cols()) * 0x1p-53;
  return defect > rounding ? nearest_orthogonal<double>(Q) : Q;
}

Posed posed(const TwoPointProblem& p, const Defects& defects) {
  const double scale = std::exp2(std::ilogb(p.inertia.cwiseAbs().maxCoeff()));
  return {p.inertia / scale, scale, repaired(p.Q_0, defects.Q_0), repaired(p.Q_T, defects.Q_T)};
}

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

double energy(const VectorXd& lambda, const MatrixXd& V) {
  return (V.cwiseAbs2() * lambda).sum() / 2;
}

/// Searches where no closed form is the answer; Λ = λI is `round`.
Found searched(const Posed& p, const TwoPointProblem& problem, bool round) {
  constexpr double most_degrees = 128;  // of a dense search
  constexpr double most_of_round =
      3e7;  // bytes of a search beyond the radius that nobody asked for
  std::optional<RoundGeodesic> logarithm;
  const auto within_radius = [](const MatrixXd& V) {
    return V.norm() <= (1 + 1e-12) * std::numbers::pi;
  };
  if (round) {
    logarithm = round_logarithm(p.Q_0, p.Q_T);
    if (logarithm && within_radius(logarithm->V))
      return {logarithm->V, Shortest::yes, 1, 0, logarithm->residual};
  }
  const double n = static_cast<double>(p.Q_0.rows()), N = static_cast<double>(p.Q_0.cols());
  const double most = logarithm && problem.restarts == 0
                          ? most_of_round
                          : static_cast<double>(TwoPointProblem::most_bytes);
  if (logarithm && search_bytes(problem) > most)
    return {logarithm->V, Shortest::unknown, 1, 0, logarithm->residual};
  Found best;
  if (p.lambda.minCoeff() > 0 && search_bytes(problem) <= most) best = by_multipliers(p, problem);
  if (best.V.size() == 0 && n * N - n * (n + 1) / 2 <= most_degrees) best = by_paths(p, problem);
  if (best.V.size() == 0) return best;
  if (logarithm && logarithm->V.norm() < (1 - 1e-12) * best.V.norm()) {
    best.V = logarithm->V;
    best.residual = logarithm->residual;
  }
  if (round && within_radius(best.V)) best.shortest = Shortest::yes;
  return best;
}

/// Says more of a geodesic than the search did: it is the shortest where it is no longer than a proven
/// bound of the injectivity radius, and is not where it passes a conjugate point.
void judge(const Posed& p, Found& best) {
  constexpr double most_work = 1e10, nearly_there = 1 - 1e-6;
  constexpr double most_degrees = 32;
  const double n = static_cast<double>(p.Q_0.rows()), N = static_cast<double>(p.Q_0.cols());
  if (best.V.size() == 0 || best.shortest == Shortest::yes) return;
  if (std::sqrt(2 * energy(p.lambda, best.V)) <= injectivity_bound(p.lambda, p.Q_0.rows()))
    best.shortest = Shortest::yes;
  // A local minimum of the action passes none.
  if (best.shortest != Shortest::unknown || n * N - n * (n + 1) / 2 > most_degrees) return;
  const auto passed = conjugate_points({p.lambda, p.Q_0, best.V, nearly_there, {}, most_work});
  if (passed && !passed->points.empty()) best.shortest = Shortest::no;
}

Found found(const Posed& p, const TwoPointProblem& problem) {
  if (p.Q_0 == p.Q_T) return {MatrixXd::Zero(p.Q_0.rows(), p.Q_0.cols()), Shortest::yes, 1, 0, 0};
  if (auto closed = closed_geodesic(p.lambda, p.Q_0, p.Q_T))
    return {std::move(closed->V), Shortest::yes, closed->distinct, closed->start};
  Found best = searched(p, problem, is_round(p.lambda) && !is_body(p.Q_0));
  judge(p, best);
  return best;
}

/// Returns max |Q(T) − Q_T| of an answer.
double residual_of(const TwoPointProblem& problem, const Geodesic& answer, const MatrixXd& Q_T) {
  if (is_body(answer.Q)) return miss(problem.inertia, answer.Q, answer.M, Q_T, problem.time);
  const auto end = geodesic_end(problem.inertia, answer.Q, answer.Qdot * problem.time);
  return end ? (*end - Q_T).cwiseAbs().maxCoeff() : std::numeric_limits<double>::infinity();
}

std::expected<Geodesic, ConnectRefusal> search(const TwoPointProblem& problem,
                                               const Defects& defects) {
  const Posed p = posed(problem, defects);
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
      std::isfinite(best.residual) ? best.residual : residual_of(problem, answer, p.Q_T);
  if (!(answer.residual <= TwoPointProblem::joined))
    return std::unexpected(refusal::NotConverged{answer.residual});
  return answer;
}

std::expected<DiscreteGeodesic, ConnectRefusal> search(const TwoPointProblem& problem,
                                                       const Defects& defects, int K) {
  constexpr double tolerance = 1e-10, stationary = 1e-12;
  const Posed p = posed(problem, defects);
  std::vector<RelaxedPath> all = relaxed(p, problem, K, tolerance);
  std::erase_if(all, [](const RelaxedPath& c) { return !c.settled; });
  if (problem.stop.stop_requested()) return std::unexpected(refusal::Cancelled{});
  if (all.empty())
    return std::unexpected(refusal::NotConverged{std::numeric_limits<double>::infinity()});

  const RelaxedPath& best = all.front();
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
  Defects defects;
  if (const auto refusal = refused(problem, defects)) return std::unexpected(*refusal);
  if (const auto refusal = too_large(problem)) return std::unexpected(*refusal);
  return within(problem, [&] { return search(problem, defects); });
}

std::expected<DiscreteGeodesic, ConnectRefusal> connect(const TwoPointProblem& problem, int K) {
  Defects defects;
  if (const auto refusal = refused(problem, defects)) return std::unexpected(*refusal);
  if (K < 1) return std::unexpected(refusal::Invalid{"K", std::to_string(K), "must be at least 1"});
  if (const auto refusal = too_large(problem, K)) return std::unexpected(*refusal);
  return within(problem, [&] { return search(problem, defects, K); });
}

}  // namespace stiefel
