#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "engine/frames/geodesics/path.h"
#include "engine/frames/jacobi/closed_geodesics.h"
#include "engine/frames/jacobi/posed_metric.h"
#include "engine/frames/jacobi/short_conjugate.h"
#include "engine/numbers/to_text.h"
#include "stiefel/conjugate_points.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class RadiusSearch {
 public:
  RadiusSearch(const VectorXd& lambda, Index n, std::uint64_t seed)
      : metric_(lambda, n), lambda_(lambda), n_(n), N_(lambda.size()), generator_(seed) {
    const ClosedCurve planar = planar_geodesic(lambda, n);
    take(planar);
  }

  void search(int starts) {
    closed_geodesics(starts);
    std::vector<Conjugated> all = geodesics_to_descend_from(starts);
    std::ranges::stable_sort(all, {}, [](const Conjugated& one) { return one.point.length; });
    if (std::cmp_greater(all.size(), starts)) all.resize(static_cast<std::size_t>(starts));
    for (Conjugated& one : all) {
      take(metric_.descended(std::move(one)));
      ++out.starts;
    }
  }

  InjectivityRadius out;

 private:
  /// Tries random geodesics of about the length of the shortest closed one that is known.
  void closed_geodesics(int starts) {
    const double known = 2 * out.least_loop;
    for (int k = 0; k < starts; ++k) {
      const auto [Q, V] = random_geodesic();
      const double length = known * (0.25 + 1.25 * uniform());
      if (const auto curve = closed_near(metric_, Q, V, length)) take(*curve);
    }
  }

  std::vector<Conjugated> geodesics_to_descend_from(int starts) {
    constexpr int tries = 4;  // random geodesics for each that is taken
    const double limit = 1.5 * out.upper;
    std::vector<Conjugated> all;
    const auto add = [&](const MatrixXd& Q, const MatrixXd& V) {
      if (auto one = metric_.first(Q, V, limit)) all.push_back(std::move(*one));
    };
    for (int k = 0; k < tries * starts; ++k) {
      const auto [Q, V] = random_geodesic();
      add(Q, V);
    }
    // One row turns from e_j to e_k, about the end of each of the axes; the others rest.
    for (Index j = 0; j < N_ && n_ < N_; ++j)
      for (Index k = 0; k < N_; ++k)
        for (Index shift = 0; shift < N_ - 2 && j != k; ++shift) {
          MatrixXd Q = MatrixXd::Zero(n_, N_), V = Q;
          Index row = 0;
          for (Index i = 0, free = 0; i < N_; ++i)
            if (i != j && i != k && (free++ + shift) % (N_ - 2) < n_ - 1) Q(++row, i) = 1;
          const double before = 0.4;
          Q(0, j) = std::cos(before), Q(0, k) = -std::sin(before);
          V(0, j) = std::sin(before), V(0, k) = std::cos(before);
          // A little of everything, without which the descent stays in a symmetric family.
          const MatrixXd P = polar(Q + 0.05 * random());
          add(P, metric_.unit(P, V + 0.05 * random()));
        }
    return all;
  }

  void take(const ClosedCurve& curve) {
    out.loops += 1;
    const double half = curve.length / 2;
    if (out.least_loop > 0 && half >= out.least_loop) return;
    out.least_loop = half;
    take(half, RadiusWitness::closed_geodesic, curve.Q, curve.V, curve.residual);
  }
  void take(const Conjugated& one) {
    constexpr double same = 1e-6;
    const double length = one.point.length;
    if (length < (1 - same) * out.least_conjugate) out.agreeing = 0;
    if (length <= (1 + same) * out.least_conjugate) ++out.agreeing;
    if (length >= out.least_conjugate) return;
    out.least_conjugate = length;
    take(length, RadiusWitness::conjugate_point, one.Q, one.V, one.point.residual);
  }
  void take(double radius, RadiusWitness witness, const MatrixXd& Q, const MatrixXd& V,
            double residual) {
    if (out.upper > 0 && radius >= out.upper) return;
    out.upper = radius;
    out.witness = witness;
    out.Q = Q;
    out.Qdot = V;
    out.residual = residual;
  }

  double uniform() { return std::generate_canonical<double, 53>(generator_); }
  MatrixXd random() {
    MatrixXd A(n_, N_);
    for (double& x : A.reshaped()) x = 2 * uniform() - 1;
    return A;
  }
  std::pair<MatrixXd, MatrixXd> random_geodesic() {
    const MatrixXd Q = n_ == N_ ? MatrixXd::Identity(N_, N_) : polar(random());
    return {Q, metric_.unit(Q, random())};
  }

  ShortConjugates metric_;
  VectorXd lambda_;
  Index n_, N_;
  std::mt19937_64 generator_;
};

}  // namespace

std::expected<InjectivityRadius, ConnectRefusal> injectivity_radius(const RadiusProblem& problem) {
  const Index n = problem.n, N = problem.inertia.size();
  if (N < 2 || n < 1 || n > N)
    return std::unexpected(refusal::Invalid{
        "n", std::to_string(n),
        "must be 1 to " + std::to_string(N) + ", the number of inertias, at least 2"});
  if (auto fault = metric_fault(problem.inertia, n, N, RadiusProblem::most_degrees)) {
    if (fault->field == "Q") fault->field = "n";
    return std::unexpected(*fault);
  }
  if (problem.starts < 0 || problem.starts > RadiusProblem::most_starts)
    return std::unexpected(
        refusal::Invalid{"starts", std::to_string(problem.starts),
                         "must be 0 to " + std::to_string(RadiusProblem::most_starts)});
  const PosedMetric metric(problem.inertia);
  const double unit = std::sqrt(metric.scale());
  RadiusSearch search(metric.lambda(), n, problem.seed);
  search.out.least_conjugate = std::numeric_limits<double>::infinity();
  const StopScope scope(problem.stop, problem.most_work);
  try {
    search.search(problem.starts);
  } catch (const Stopped&) {
    const bool stopped = problem.stop.stop_requested();
    if (!stopped && !scope.used_up()) throw;
    search.out.status.outcome = stopped ? Outcome::cancelled : Outcome::solver_stalled;
  }
  InjectivityRadius out = std::move(search.out);
  out.lower = injectivity_bound(problem.inertia, n);
  for (double* found : {&out.upper, &out.least_conjugate, &out.least_loop})
    if (*found > 0) *found = std::max(out.lower, *found * unit);
  out.Qdot /= unit;
  return out;
}

}  // namespace stiefel
