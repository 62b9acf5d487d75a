#include "stiefel/connect.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "engine/frame/geodesics/geodesic_series.h"
#include "engine/frame/geodesics/relaxation.h"
#include "engine/numbers/to_text.h"
#include "stiefel/conjugate_points.h"
#include "stiefel/stop.h"

namespace stiefel {

std::optional<refusal::Invalid> metric_fault(const Eigen::VectorXd& inertia, Eigen::Index n,
                                             Eigen::Index N) {
  using refusal::Invalid;
  if (inertia.size() != N)
    return Invalid{"inertia", std::to_string(inertia.size()) + " numbers",
                   "must have " + std::to_string(N)};
  for (Eigen::Index k = 0; k < N; ++k)
    if (!std::isfinite(inertia(k)))
      return Invalid{"inertia[" + std::to_string(k) + "]", to_text(inertia(k)), "must be finite"};
  Eigen::VectorXd sorted = inertia;
  std::partial_sort(sorted.begin(), sorted.begin() + 2, sorted.end());
  if (n < N && !(sorted(0) > 0))
    return Invalid{"inertia", "smallest " + to_text(sorted(0)), "must be positive for n < N"};
  if (n == N && !(sorted(0) + sorted(1) > 0))
    return Invalid{"inertia", "the two smallest add up to " + to_text(sorted(0) + sorted(1)),
                   "every two must have a positive sum"};
  return {};
}

namespace {

bool is_body(const MatrixXd& Q) { return Q.rows() == Q.cols(); }

/// Returns max |QQᵀ − I| from QQᵀ; infinite where it is not finite.
double defect(const MatrixXd& product) {
  const double largest =
      (product - MatrixXd::Identity(product.rows(), product.rows())).cwiseAbs().maxCoeff();
  return product.allFinite() ? largest : std::numeric_limits<double>::infinity();
}

/// Whether the metric is one of β whose geodesics are not those of Λ = I.
bool is_bent(const TwoPointProblem& p) {
  return p.beta && *p.beta != 1 && p.Q_0.rows() > 1 && !is_body(p.Q_0);
}

std::optional<ConnectRefusal> refused(const TwoPointProblem& p) {
  using refusal::Invalid;
  const Index n = p.Q_0.rows(), N = p.Q_0.cols();
  if (n < 1 || n > N || N < 2)
    return Invalid{"Q_0", shape(p.Q_0), "must have 1 <= n <= N rows of N >= 2 numbers"};
  if (p.Q_T.rows() != n || p.Q_T.cols() != N)
    return Invalid{"Q_T", shape(p.Q_T), "must have the shape of Q_0, " + shape(p.Q_0)};
  if (auto fault = metric_fault(p.inertia, n, N)) return fault;
  if (!(std::isfinite(p.time) && p.time > 0))
    return Invalid{"time", to_text(p.time), "must be positive and finite"};
  if (p.restarts < 0)
    return Invalid{"restarts", std::to_string(p.restarts), "must not be negative"};
  return {};
}

/// Refuses what is no frame, and frames that no path joins.
std::optional<ConnectRefusal> refused(const TwoPointProblem& p, const FrameProducts& products) {
  for (const auto& [field, product] :
       {std::pair("Q_0", &products.of_Q_0), std::pair("Q_T", &products.of_Q_T)})
    if (const double error = defect(*product); !(error <= Scene::frame_tolerance))
      return refusal::NotOrthonormal{field, error};
  if (is_body(p.Q_0)) {
    const int first = determinant(p.Q_0) < 0 ? -1 : 1, last = determinant(p.Q_T) < 0 ? -1 : 1;
    if (first != last) return refusal::UnequalDeterminants{first, last};
  }
  return {};
}

/// Returns the bytes of a step of a path whose relaxation is asked for. Dense: five d × d blocks
/// and a basis of d directions for every inner frame, for all starts at once; else the equations of
/// the multipliers, and the eigenvectors of K n.
double step_bytes(const TwoPointProblem& p, int K) {
  const double nN = static_cast<double>(p.Q_0.size()), n = static_cast<double>(p.Q_0.rows());
  const double d = connect_work::degrees(p.Q_0.rows(), p.Q_0.cols());
  if (d <= most_dense_degrees || !(p.inertia.minCoeff() > 0))
    return 8 * (5 * d * d + nN * d + nN * (p.restarts + 3.0));
  const double unknowns =
      std::min(K * n * (n + 1) / 2, static_cast<double>(Relaxation::most_dense));
  return 8 * (2 * unknowns * unknowns / K + 6 * n * n * K + nN * (p.restarts + 12.0));
}

/// Returns the bytes of a search by the multipliers: two sets of their equations and factors at 17
/// nodes, for a wide Λ at up to 129, the paths, and a Taylor series.
double search_bytes(const TwoPointProblem& p) {
  const double n = static_cast<double>(p.Q_0.rows()), nN = static_cast<double>(p.Q_0.size());
  const bool wide = is_wide(p.inertia);
  const double each = n * (n + 1) / 2, nodes = 15, most = Relaxation::most_dense,
               unknowns = std::min((wide ? 127 : nodes) * each, most),
               modes = n * std::max(nodes, unknowns / each);
  const double starts = std::max(p.restarts, 4) + 1 + n / 2;
  return 8 * ((wide ? 5 : 4) * unknowns * unknowns + 8 * modes * modes +
              nN * ((nodes + 2) * starts + 12 * nodes + 160));
}

/// Refuses what would need too much memory: a path of K steps, or a search.
std::optional<ConnectRefusal> too_large(const TwoPointProblem& p, std::optional<int> K) {
  const double most = static_cast<double>(TwoPointProblem::most_bytes);
  const std::string restarts = std::to_string(p.restarts) + " restarts",
                    bound = std::to_string(TwoPointProblem::most_bytes >> 20) + " MiB";
  const auto whole = [](double x) { return std::to_string(static_cast<std::int64_t>(x)); };
  if (K) {
    const double each = step_bytes(p, *K);
    if (each * *K <= most) return {};
    return refusal::Invalid{"steps", std::to_string(*K),
                            "must be at most " + whole(most / each) + " for frames of " +
                                std::to_string(p.Q_0.size()) + " numbers and " + restarts +
                                ": a step takes " + whole(each / 1024) + " KiB of " + bound};
  }
  const double bytes = search_bytes(p);
  if (bytes <= most || is_round(p.inertia)) return {};
  return refusal::Invalid{"Q_0", shape(p.Q_0),
                          "a search with different inertias and " + restarts +
                              " must take at most " + bound + ", and takes " +
                              whole(bytes / 0x1p20)};
}

/// Returns a frame as it is where repairing it would leave it, else the nearest frame in
/// `repaired`.
const MatrixXd& frame(const MatrixXd& Q, const MatrixXd& product, MatrixXd& repaired) {
  if (defect(product) <= 4 * static_cast<double>(Q.cols()) * 0x1p-53) return Q;
  return repaired = nearest_orthogonal<double>(Q);
}

/// Returns the power of 2 that leaves a Λ of the order of 1.
double scale_of(const VectorXd& inertia) {
  return std::exp2(std::ilogb(inertia.cwiseAbs().maxCoeff()));
}

/// Calls `solve` with a problem that can be solved and has a Λ, the products of its frames, and the
/// scope of its work and stop token; or returns what is wrong. A metric of β gets
/// the Λ of the same geodesics and energy, or Λ = I where `is_bent`. `K`: of the discrete problem.
template <class Answer, class Solve>
std::expected<Answer, ConnectRefusal> checked(const TwoPointProblem& given, std::optional<int> K,
                                              const Solve& solve) {
  using refusal::Invalid;
  TwoPointProblem with_inertia;
  if (given.beta) {
    if (!(std::isfinite(*given.beta) && *given.beta > 0))
      return std::unexpected(Invalid{"beta", to_text(*given.beta), "must be positive and finite"});
    if (given.inertia.size() > 0)
      return std::unexpected(Invalid{"inertia", std::to_string(given.inertia.size()) + " numbers",
                                     "must be absent with beta"});
    with_inertia = given;
    with_inertia.inertia =
        VectorXd::Constant(given.Q_0.cols(), is_body(given.Q_0) ? *given.beta : 1);
  }
  const TwoPointProblem& problem = given.beta ? with_inertia : given;
  if (auto fault = refused(problem)) return std::unexpected(*fault);
  if (K && *K < 1) return std::unexpected(Invalid{"K", std::to_string(*K), "must be at least 1"});
  if (K && is_bent(problem))
    return std::unexpected(
        Invalid{"steps", std::to_string(*K), "must be 0 in a metric of beta without a Lambda"});
  const FrameProducts products = frame_products(problem.Q_0, problem.Q_T);
  if (auto fault = refused(problem, products)) return std::unexpected(*fault);
  if (auto fault = too_large(problem, K)) return std::unexpected(*fault);
  const StopScope scope(problem.stop, problem.most_work);
  try {
    return solve(problem, products, scope);
  } catch (const Stopped&) {
    if (problem.stop.stop_requested()) return std::unexpected(refusal::Cancelled{});
    if (!scope.used_up()) throw;
    return std::unexpected(refusal::NotConverged{std::numeric_limits<double>::infinity(), true});
  }
}

/// Says more of a geodesic than the search did: it is the shortest where it is no longer than a
/// proven bound of the injectivity radius, and is not where it passes a conjugate point.
void judge(const VectorXd& lambda, const MatrixXd& Q_0, Found& best) {
  constexpr double most_work = 1e10, nearly_there = 1 - 1e-6;
  constexpr double most_degrees = 32;
  if (best.V.size() == 0 || best.shortest == Shortest::yes) return;
  if (std::sqrt(2 * energy(lambda, best.V)) <= injectivity_bound(lambda, Q_0.rows()))
    best.shortest = Shortest::yes;
  // A local minimum of the action passes none.
  if (best.shortest != Shortest::unknown ||
      connect_work::degrees(Q_0.rows(), Q_0.cols()) > most_degrees)
    return;
  const auto passed = conjugate_points({lambda, Q_0, best.V, nearly_there, {}, most_work});
  if (passed && !passed->points.empty()) best.shortest = Shortest::no;
}

/// Searches from Q_T where the search from Q_0 joins nothing, or sees a shorter path than it joins.
void by_multipliers_from_both_ends(const Posed& p, const TwoPointProblem& problem, Found& best) {
  by_multipliers(p, problem, best);
  if (best.V.size() > 0 && best.shortest != Shortest::no) return;
  Found back;
  by_multipliers({p.lambda, p.Q_T, p.Q_0}, problem, back);
  if (back.V.size() == 0) return;
  if (best.V.size() > 0 && !(energy(p.lambda, back.V) < energy(p.lambda, best.V))) return;
  const auto start = geodesic_end(p.lambda, p.Q_T, back.V);
  if (!start) return;
  back.V = -start->V;
  const auto end = geodesic_end(p.lambda, p.Q_0, back.V);
  if (!end) return;
  back.residual = (end->Q - p.Q_T).cwiseAbs().maxCoeff();
  if (back.residual <= TwoPointProblem::joined) best = std::move(back);
}

/// Finds a geodesic by the logarithm of β, a closed form or a search. `products` are those of the
/// frames.
void find(const TwoPointProblem& problem, const MatrixXd& Q_0, const MatrixXd& Q_T,
          const FrameProducts& products, Found& best) {
  const Index n = Q_0.rows(), N = Q_0.cols();
  const VectorXd lambda = problem.inertia / scale_of(problem.inertia);
  if (Q_0 == Q_T) {
    best = {MatrixXd::Zero(n, N), Shortest::yes, 1, 0, 0};
  } else if (1 < n && n < N && is_round(lambda)) {
    round_logarithm(Q_0, Q_T, products, problem, best);
    if (is_bent(problem)) return;
    judge(lambda, Q_0, best);
    if (best.shortest == Shortest::unknown) best.shortest = Shortest::none_shorter_found;
  } else if (auto closed = closed_geodesic(lambda, Q_0, Q_T)) {
    best = *std::move(closed);
  } else {
    const Posed p{lambda, Q_0, Q_T};
    if (lambda.minCoeff() > 0)
      by_multipliers_from_both_ends(p, problem, best);
    else if (connect_work::degrees(n, N) <= most_dense_degrees)
      by_paths(p, problem, best);
    judge(lambda, Q_0, best);
  }
}

/// Returns what was found from the frame Q_0 as an answer.
std::expected<Geodesic, ConnectRefusal> answered(const TwoPointProblem& problem, Found best,
                                                 const MatrixXd& Q_0, const MatrixXd& Q_T) {
  if (problem.stop.stop_requested()) return std::unexpected(refusal::Cancelled{});
  if (best.V.size() == 0) return std::unexpected(refusal::NotConverged{best.residual});
  Geodesic answer;
  answer.shortest = best.shortest;
  answer.distinct = best.distinct;
  answer.start = best.start;
  answer.Q = Q_0;
  answer.Qdot = std::move(best.V);
  if (problem.time != 1) answer.Qdot /= problem.time;
  if (!is_bent(problem)) answer.S = answer.Qdot * problem.inertia.asDiagonal();
  if (is_body(Q_0)) answer.M = momentum(problem.inertia, Q_0, answer.Qdot);
  answer.energy = best.length ? *best.length * (*best.length * problem.inertia(0)) / 2 /
                                    (problem.time * problem.time)
                              : energy(problem.inertia, answer.Qdot);
  if (!std::isfinite(answer.energy))
    return std::unexpected(
        refusal::Invalid{"time", to_text(problem.time), "makes an energy that is not finite"});
  answer.residual = best.residual;
  if (!std::isfinite(best.residual))  // a closed form
    if (const auto end = geodesic_end(problem.inertia, Q_0, answer.Qdot * problem.time))
      answer.residual = (end->Q - Q_T).cwiseAbs().maxCoeff();
  if (!(answer.residual <= TwoPointProblem::joined))
    return std::unexpected(refusal::NotConverged{answer.residual});
  return answer;
}

std::expected<Geodesic, ConnectRefusal> search(const TwoPointProblem& problem,
                                               const FrameProducts& products,
                                               const StopScope& scope) {
  MatrixXd repaired_0, repaired_T;
  const MatrixXd &Q_0 = frame(problem.Q_0, products.of_Q_0, repaired_0),
                 &Q_T = frame(problem.Q_T, products.of_Q_T, repaired_T);
  const bool as_given = &Q_0 == &problem.Q_0 && &Q_T == &problem.Q_T;
  Found best;
  try {
    find(problem, Q_0, Q_T, as_given ? products : frame_products(Q_0, Q_T), best);
  } catch (const Stopped&) {
    if (!scope.used_up() || problem.stop.stop_requested() || best.V.size() == 0) throw;
    if (best.shortest != Shortest::yes) best.shortest = Shortest::ended;
  }
  const StopScope rest = scope.used_up() ? StopScope::nothing() : StopScope(problem.stop);
  return answered(problem, std::move(best), Q_0, Q_T);
}

std::expected<DiscreteGeodesic, ConnectRefusal> search(const TwoPointProblem& problem,
                                                       const FrameProducts& products, int K) {
  constexpr double tolerance = 1e-10, stationary = 1e-12;
  MatrixXd repaired_0, repaired_T;
  const double scale = scale_of(problem.inertia);
  const Posed p{problem.inertia / scale, frame(problem.Q_0, products.of_Q_0, repaired_0),
                frame(problem.Q_T, products.of_Q_T, repaired_T)};
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
  result.energy = best.action * scale / (problem.time * problem.time);
  result.residual = residual;
  result.distinct = static_cast<int>(all.size());
  result.start = best.start;
  return result;
}

}  // namespace

std::optional<ConnectRefusal> refusal_of(const TwoPointProblem& given) {
  const auto fine =
      checked<bool>(given, {}, [](const auto&, const auto&, const auto&) { return true; });
  return fine ? std::nullopt : std::optional(fine.error());
}

std::expected<Geodesic, ConnectRefusal> connect(const TwoPointProblem& given) {
  return checked<Geodesic>(
      given, {}, [](const TwoPointProblem& problem, const auto& products, const auto& scope) {
        return search(problem, products, scope);
      });
}

std::expected<DiscreteGeodesic, ConnectRefusal> connect(const TwoPointProblem& given, int K) {
  return checked<DiscreteGeodesic>(
      given, K, [K](const TwoPointProblem& problem, const auto& products, const auto&) {
        return search(problem, products, K);
      });
}

}  // namespace stiefel
