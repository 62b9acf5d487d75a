#include "engine/frames/jacobi/closed_geodesics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/frames/geodesics/path.h"
#include "engine/frames/jacobi/posed_metric.h"
#include "engine/linalg/matrix_equations/decompositions.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Returns the perimeter of an ellipse by the arithmetic-geometric mean (DLMF 19.8.6).
double perimeter(double a, double b) {
  double sum = (a * a + b * b) / 2, weight = 1;
  while (std::abs(a - b) > 1e-9 * a) {
    const double mean = (a + b) / 2, half = (a - b) / 2;
    sum -= weight * half * half;
    weight *= 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2 * std::numbers::pi * sum / ((a + b) / 2);
}

}  // namespace

ClosedCurve planar_geodesic(const VectorXd& lambda, Index n) {
  const Index N = lambda.size();
  std::vector<Index> order(static_cast<std::size_t>(N));
  for (Index k = 0; k < N; ++k) order[static_cast<std::size_t>(k)] = k;
  std::ranges::sort(order, {}, [&](Index k) { return lambda(k); });
  const Index j = order[0], k = order[1];
  MatrixXd Q = MatrixXd::Zero(n, N), V = Q;
  if (n == N) {
    Q.setIdentity();
    const double speed = std::sqrt(lambda(j) + lambda(k));
    V(j, k) = 1 / speed;
    V(k, j) = -1 / speed;
    return {Q, V, 2 * std::numbers::pi * speed, 0};
  }
  Q(0, j) = 1;
  V(0, k) = 1 / std::sqrt(lambda(k));
  for (Index row = 1; row < n; ++row) Q(row, order[static_cast<std::size_t>(row + 1)]) = 1;
  return {Q, V, perimeter(std::sqrt(lambda(k)), std::sqrt(lambda(j))), 0};
}

std::optional<ClosedCurve> closed_near(const ShortConjugates& metric, const MatrixXd& Q_0,
                                       const MatrixXd& V_0, double length) {
  constexpr int iterations = 30;
  constexpr double epsilon = 1e-7, longest_step = 0.3, closed = 1e-11, small = 1e-6;
  const Index n = Q_0.rows(), N = Q_0.cols(), size = n * N;
  const bool body = n == N;
  const auto miss = [&](const MatrixXd& Q, const MatrixXd& V, double L) -> std::optional<VectorXd> {
    const auto x = metric.moved(metric.flow().start(Q, V, MatrixXd(size, 0)), L);
    if (!x) return {};
    VectorXd r(2 * size);
    r << (metric.flow().frame(*x) - Q).reshaped(), (metric.flow().velocity(*x) - V).reshaped();
    return r;
  };
  MatrixXd Q = Q_0, V = V_0;
  const double first = length;
  auto rest = miss(Q, V, length);
  double damping = 1;
  for (int k = 0; k < iterations && rest; ++k) {
    if (!(length > first / 8 && length < 4 * first)) return {};
    const double size_of_rest = rest->cwiseAbs().maxCoeff();
    if (size_of_rest <= closed) return ClosedCurve{Q, V, length, size_of_rest};
    const MatrixXd Z = tangent_basis(Q);
    const Index d = Z.cols();
    MatrixXd J = MatrixXd::Zero(2 * size, 2 * d + 1);
    const auto place = [&](const VectorXd& y) {
      const MatrixXd P = body ? Q : polar(Q + (Z * y.head(d)).reshaped(n, N));
      return std::pair(P, metric.unit(P, V + (Z * y.segment(d, d)).reshaped(n, N)));
    };
    for (Index i = body ? d : 0; i <= 2 * d; ++i) {
      const VectorXd y = epsilon * VectorXd::Unit(2 * d + 1, i);
      const auto [P, W] = place(y);
      const auto changed = miss(P, W, length + y(2 * d));
      if (!changed) return {};
      J.col(i) = (*changed - *rest) / epsilon;
    }
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    solver.setThreshold(small);
    solver.compute(J);
    VectorXd step = -solver.solve(*rest);
    step *= std::min(damping, longest_step / step.norm());
    const auto [P, W] = place(step);
    auto left = miss(P, W, length + step(2 * d));
    if (!left) return {};
    damping = left->norm() < rest->norm() ? std::min(1.0, 2 * damping) : damping / 2;
    if (damping < 0.05) return {};
    Q = P;
    V = W;
    length += step(2 * d);
    rest = std::move(left);
  }
  return {};
}

}  // namespace stiefel
