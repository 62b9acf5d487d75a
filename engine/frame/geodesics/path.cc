#include "engine/frame/geodesics/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "engine/frame/geodesics/relaxation.h"
#include "engine/frame/stiefel_momenta.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

std::size_t steps(const Path& path) { return path.size() - 1; }

double sums(const Path& path) {
  return connect_work::sums(std::ssize(path), path[0].rows(), path[0].cols());
}

MatrixXd gradient(const VectorXd& lambda, const Path& path, std::size_t k) {
  const double K = static_cast<double>(steps(path));
  return K * (2 * path[k] - path[k + 1] - path[k - 1]) * lambda.asDiagonal();
}

/// The quadratic model of the action at a path, in the coordinates of the tangent bases E_k of the
/// path's inner frames.
class Model {
 public:
  Model(const VectorXd& lambda, const Path& path)
      : frame_(connect_work::frame(path[0].rows(), path[0].cols())),
        size_(static_cast<double>(path[0].size())),
        degrees_(connect_work::degrees(path[0].rows(), path[0].cols())) {
    const Index n = path[0].rows(), N = path[0].cols();
    const double K = static_cast<double>(steps(path));
    weight_ = K * lambda.transpose().replicate(n, 1).reshaped();
    MatrixXd weighted;
    for (std::size_t k = 1; k < steps(path); ++k) {
      stop_point(frame_ + 5 * size_ * degrees_ * (degrees_ + 27));
      const MatrixXd& Q = path[k];
      const MatrixXd g = gradient(lambda, path, k);
      const MatrixXd E = tangent_basis(Q);
      if (k > 1) outer_.push_back(-weighted.transpose() * E);
      weighted = weight_.asDiagonal() * E;

      MatrixXd multiplied = E;  // sym(gQᵀ)δ for every basis vector δ
      const MatrixXd Sigma = (g * Q.transpose() + Q * g.transpose()) / 2;
      multiplied.reshaped(n, N * E.cols()) = Sigma * E.reshaped(n, N * E.cols());
      metric_.push_back(E.transpose() * weighted);
      inner_.push_back(2 * metric_.back() - E.transpose() * multiplied);
      gradient_.push_back(E.transpose() * g.reshaped());
      basis_.push_back(E);
    }
  }

  /// Solves (Hessian + shift · metric) x = −gradient, or for the change of the path where its end
  /// moves by `end`. Returns false where that matrix is not positive.
  bool solve(double shift, const MatrixXd* end = nullptr) {
    const std::size_t count = inner_.size();
    std::vector<MatrixXd> factors;
    std::vector<MatrixXd> carried;
    step_.assign(count, VectorXd());
    for (std::size_t k = 0; k < count; ++k) {
      stop_point(5 * degrees_ * (degrees_ + 12) * (degrees_ + 12));
      MatrixXd D = inner_[k] + shift * metric_[k];
      step_[k] = (end ? 0 : -1) * gradient_[k];
      if (end && k + 1 == count)
        step_[k] = basis_[k].transpose() * weight_.cwiseProduct(end->reshaped());
      if (k > 0) {
        carried.push_back(outer_[k - 1]);
        solve_positive(factors.back(), carried.back());
        D.noalias() -= outer_[k - 1].transpose() * carried.back();
        step_[k].noalias() -= carried.back().transpose() * step_[k - 1];
      }
      if (!factor_positive(D)) return false;
      factors.push_back(std::move(D));
    }
    for (std::size_t k = count; k-- > 0;) {
      solve_positive(factors[k], step_[k]);
      if (k + 1 < count) step_[k].noalias() -= carried[k] * step_[k + 1];
    }
    return true;
  }

  double largest_step() const {
    double largest = 0;
    for (const VectorXd& x : step_) largest = std::max(largest, x.cwiseAbs().maxCoeff());
    return largest;
  }
  /// Returns the change of the first inner frame.
  MatrixXd first(const MatrixXd& Q) const {
    return (basis_[0] * step_[0]).reshaped(Q.rows(), Q.cols());
  }
  Path moved(const Path& path) const {
    Path result = path;
    for (std::size_t k = 0; k < step_.size(); ++k) {
      stop_point(frame_ + 4 * size_ * degrees_);
      const VectorXd delta = basis_[k] * step_[k];
      result[k + 1] = polar(path[k + 1] + delta.reshaped(path[0].rows(), path[0].cols()));
    }
    return result;
  }

 private:
  double frame_, size_, degrees_;  ///< work and numbers of a frame, and its degrees of freedom
  VectorXd weight_;                ///< K times Λ, acting on a tangent vector as a column
  std::vector<MatrixXd> basis_, metric_, inner_, outer_;
  std::vector<VectorXd> gradient_, step_;
};

}  // namespace

MatrixXd polar(const MatrixXd& A) {
  const MatrixXd square = A * A.transpose();
  const MatrixXd Q = symmetric_inverse_root(square) * A;
  // Squaring a nearly singular A loses digits; one Newton–Schulz step restores them.
  return (3 * Q - (Q * Q.transpose()) * Q) / 2;
}

MatrixXd complement(const MatrixXd& Q) {
  const Index n = Q.rows(), N = Q.cols();
  return orthonormal_columns<double>(Q.transpose(), N - n, n).transpose();
}

MatrixXd tangent_basis(const MatrixXd& Q) {
  const Index n = Q.rows(), N = Q.cols();
  const MatrixXd R = complement(Q);
  MatrixXd E = MatrixXd::Zero(n * N, n * N - n * (n + 1) / 2);
  Index column = 0;
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < i; ++j, ++column) {
      auto delta = E.col(column).reshaped(n, N);
      delta.row(i) = Q.row(j) * std::numbers::sqrt2 / 2;
      delta.row(j) = -Q.row(i) * std::numbers::sqrt2 / 2;
    }
    for (Index j = 0; j < N - n; ++j, ++column) E.col(column).reshaped(n, N).row(i) = R.row(j);
  }
  return E;
}

double action(const VectorXd& lambda, const Path& path) {
  stop_point(sums(path));
  double sum = 0;
  for (std::size_t k = 0; k < steps(path); ++k)
    sum += ((path[k + 1] - path[k]).cwiseAbs2() * lambda).sum();
  return static_cast<double>(steps(path)) * sum / 2;
}

double largest_gradient(const VectorXd& lambda, const Path& path) {
  double largest = 0;
  for (std::size_t k = 1; k + 1 < path.size(); ++k) {
    stop_point(sums(path) / static_cast<double>(path.size()));
    const MatrixXd g = (2 * path[k] - path[k + 1] - path[k - 1]) * lambda.asDiagonal(),
                   B = g * path[k].transpose();
    largest = std::max(largest, (g - (B + B.transpose()) / 2 * path[k]).cwiseAbs().maxCoeff());
  }
  return largest / lambda.maxCoeff();
}

Path refined(const Path& path) {
  Path result = {path[0]};
  for (std::size_t k = 0; k < steps(path); ++k) {
    stop_point(connect_work::frame(path[0].rows(), path[0].cols()));
    result.push_back(polar((path[k] + path[k + 1]) / 2));
    result.push_back(path[k + 1]);
  }
  return result;
}

double distance(const Path& a, const Path& b) {
  stop_point(sums(a));
  double largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    largest = std::max(largest, (a[k] - b[k]).cwiseAbs().maxCoeff());
  return largest;
}

MatrixXd initial_velocity(const VectorXd& lambda, const Path& path) {
  const double K = static_cast<double>(path.size() - 1);
  const MatrixXd &Q = path[0], D = K * (path[1] - Q);
  if (Q.rows() == Q.cols()) {
    const MatrixXd UL = K * (Q.transpose() * path[1]) * lambda.asDiagonal();
    const MatrixXd twice_skew = UL - UL.transpose();
    return Q * inverse_inertia<double>(lambda, twice_skew);
  }
  return tangent_velocity<double>(lambda, Q, D);
}

MatrixXd response(const VectorXd& lambda, const Path& path, const MatrixXd& end) {
  Model model(lambda, path);
  if (!model.solve(0, &end)) return MatrixXd::Zero(end.rows(), end.cols());
  const MatrixXd &Q = path[0], V = static_cast<double>(steps(path)) * model.first(Q),
                 along = V * Q.transpose();
  return V - (along + along.transpose()) / 2 * Q;
}

bool relax(const VectorXd& lambda, Path& path, double tolerance, const std::stop_token& stop) {
  constexpr int iterations = 80;
  constexpr double smallest_shift = 1e-4, largest_shift = 1e6, rounding = 1e-13;
  const double K = static_cast<double>(steps(path));
  const double unit = std::pow(std::numbers::pi / K, 2);  // the lowest mode of the metric part
  double value = action(lambda, path), shift = 0;
  for (int iteration = 0; iteration < iterations && !stop.stop_requested(); ++iteration) {
    Model model(lambda, path);
    for (;; shift = std::max(4 * shift, smallest_shift)) {
      if (shift > largest_shift) return false;
      if (!model.solve(shift * unit)) continue;
      const Path trial = model.moved(path);
      const double reached = action(lambda, trial);
      if (!(reached <= value + rounding * std::abs(value))) continue;
      path = trial;
      value = reached;
      break;
    }
    if (model.largest_step() <= tolerance) return true;
    shift = shift > smallest_shift ? shift / 8 : 0;
  }
  return false;
}

namespace {

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
       starts(posed.Q_0, posed.Q_T, times, problem.restarts, problem.seed, is_wide(posed.lambda))) {
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
