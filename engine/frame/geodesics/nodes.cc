#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/relaxation.h"
#include "stiefel/stop.h"

namespace stiefel {

namespace {

/// Returns P_K(x).
double legendre(int K, double x) {
  double before = 1, value = x;
  for (int k = 2; k <= K; ++k)
    before = std::exchange(value, ((2 * k - 1) * x * value - (k - 1) * before) / k);
  return value;
}

/// Returns the matrix that takes the values at the nodes to those of their polynomials at `times`.
MatrixXd interpolation(const Nodes& nodes, const VectorXd& times) {
  const Index K = (nodes.times.size() - 1) / (nodes.breaks.size() - 1);
  MatrixXd L = MatrixXd::Zero(times.size(), nodes.times.size());
  for (Index i = 0; i < times.size(); ++i) {
    Index piece = 0;
    while (piece + 2 < nodes.breaks.size() && nodes.breaks(piece + 1) <= times(i)) ++piece;
    const auto t = nodes.times.segment(piece * K, K + 1);
    for (Index j = 0; j <= K; ++j) {
      double& value = L(i, piece * K + j) = 1;
      for (Index k = 0; k <= K; ++k)
        if (k != j) value *= (times(i) - t(k)) / (t(j) - t(k));
    }
  }
  return L;
}

MatrixXd combined(const Path& path, const Eigen::RowVectorXd& factors) {
  MatrixXd Q = MatrixXd::Zero(path[0].rows(), path[0].cols());
  for (Index j = 0; j < factors.size(); ++j)
    if (factors(j) != 0) Q += factors(j) * path[static_cast<std::size_t>(j)];
  return Q;
}

/// Returns the nodes of one piece, without the root.
Nodes piece(int K) {
  Nodes nodes;
  VectorXd x(K + 1), P(K + 1);
  x(0) = -1;
  x(K) = 1;
  if (K > 1) {  // the roots of P_K′, which are eigenvalues of the matrix of its recurrence
    MatrixXd recurrence = MatrixXd::Zero(K - 1, K - 1);
    for (int k = 1; k < K - 1; ++k)
      recurrence(k, k - 1) = std::sqrt(k * (k + 2.0) / ((2 * k + 1) * (2 * k + 3)));
    const VectorXd roots = symmetric_eigenvalues(recurrence);
    x.segment(1, K - 1) = (roots - roots.reverse()) / 2;
  }
  for (int k = 0; k <= K; ++k) P(k) = legendre(K, x(k));
  nodes.times = (x.array() + 1) / 2;
  nodes.weights = 1 / (K * (K + 1.0) * P.array().square());
  MatrixXd D = MatrixXd::Zero(K + 1, K + 1);
  for (int i = 0; i <= K; ++i)
    for (int j = 0; j <= K; ++j)
      if (i != j) D(i, j) = 2 * P(i) / (P(j) * (x(i) - x(j)));
  D.diagonal() = -D.rowwise().sum();
  nodes.start = D.row(0);
  nodes.stiffness = D.transpose() * nodes.weights.asDiagonal() * D;
  return nodes;
}

}  // namespace

Nodes equally_spaced(int K) { return pieces(VectorXd::LinSpaced(K + 1, 0, 1), 1); }

Nodes pieces(const VectorXd& breaks, int K) {
  const Index count = breaks.size() - 1, size = count * K + 1;
  const Nodes one = piece(K);
  Nodes nodes;
  nodes.times = nodes.weights = VectorXd::Zero(size);
  nodes.stiffness = MatrixXd::Zero(size, size);
  nodes.start = Eigen::RowVectorXd::Zero(size);
  for (Index i = 0; i < count; ++i) {
    const double length = breaks(i + 1) - breaks(i);
    nodes.times.segment(i * K, K + 1) = breaks(i) + length * one.times.array();
    nodes.weights.segment(i * K, K + 1) += length * one.weights;
    nodes.stiffness.block(i * K, i * K, K + 1, K + 1) += one.stiffness / length;
  }
  nodes.times(size - 1) = 1;
  nodes.start.head(K + 1) = one.start / breaks(1);
  const MatrixXd inner = nodes.stiffness.block(1, 1, size - 2, size - 2);
  nodes.inverse_root = symmetric_inverse_root(inner);
  nodes.breaks = breaks;
  return nodes;
}

Path moved(const Path& path, const Nodes& from, const Nodes& to) {
  const Index n = path[0].rows(), N = path[0].cols();
  const MatrixXd L = interpolation(from, to.times);
  Path out = {path.front()};
  for (Index i = 1; i + 1 < L.rows(); ++i) {
    stop_point(connect_work::frame(n, N) + connect_work::sums(L.cols(), n, N));
    out.push_back(polar(combined(path, L.row(i))));
  }
  out.push_back(path.back());
  return out;
}

VectorXd defects(const Path& path, const Nodes& nodes) {
  const Index count = nodes.breaks.size() - 1, steps = nodes.times.size() - 1;
  const MatrixXd L = interpolation(nodes, (nodes.times.head(steps) + nodes.times.tail(steps)) / 2);
  VectorXd out = VectorXd::Zero(count);
  for (Index i = 0; i < steps; ++i) {
    stop_point(connect_work::sums(L.cols(), path[0].rows(), path[0].cols()));
    double& defect = out(i / (steps / count));
    defect = std::max(defect, orthogonality_defect(combined(path, L.row(i))));
  }
  return out;
}

}  // namespace stiefel
