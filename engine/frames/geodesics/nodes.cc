#include "engine/frames/geodesics/nodes.h"

#include <cmath>
#include <numbers>

#include "engine/linalg/matrix_equations/eigenvectors.h"

namespace stiefel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct Legendre {
  double value, before;  ///< P_K(x), P_{K−1}(x)
};

Legendre legendre(int K, double x) {
  double before = 1, value = x;
  for (int k = 2; k <= K; ++k) {
    const double next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
    before = value;
    value = next;
  }
  return {value, before};
}

}  // namespace

Nodes lobatto(int K) {
  Nodes nodes;
  VectorXd x(K + 1), P(K + 1);
  for (int k = 0; k <= K; ++k) {
    x(k) = -std::cos(std::numbers::pi * k / K);
    if (k > 0 && k < K)  // roots of P_K', with (1−x²)P_K' = K(P_{K−1} − xP_K)
      for (int i = 0; i < 20; ++i) {
        const auto [value, before] = legendre(K, x(k));
        x(k) += (before - x(k) * value) / ((K + 1) * value);
      }
    if (2 * k == K) x(k) = 0;
    P(k) = legendre(K, x(k)).value;
  }
  nodes.times = (x.array() + 1) / 2;
  nodes.weights = 1 / (K * (K + 1.0) * P.array().square());
  MatrixXd D = MatrixXd::Zero(K + 1, K + 1);
  for (int i = 0; i <= K; ++i)
    for (int j = 0; j <= K; ++j)
      if (i != j) D(i, j) = 2 * P(i) / (P(j) * (x(i) - x(j)));
  D.diagonal() = -D.rowwise().sum();
  nodes.start = D.row(0);
  nodes.stiffness = D.transpose() * nodes.weights.asDiagonal() * D;
  const MatrixXd inner = nodes.stiffness.block(1, 1, K - 1, K - 1);
  nodes.inverse_root = Eigen::SelfAdjointEigenSolver<MatrixXd>(inner).operatorInverseSqrt();
  return nodes;
}

Nodes equally_spaced(int K) {
  Nodes nodes;
  nodes.times = VectorXd::LinSpaced(K + 1, 0, 1);
  nodes.weights = VectorXd::Constant(K + 1, 1.0 / K);
  nodes.weights(0) = nodes.weights(K) = 0.5 / K;
  nodes.start = Eigen::RowVectorXd::Zero(K + 1);
  nodes.start(0) = -K;
  nodes.start(1) = K;
  nodes.stiffness = MatrixXd::Zero(K + 1, K + 1);
  nodes.stiffness.diagonal().setConstant(2 * K);
  nodes.stiffness(0, 0) = nodes.stiffness(K, K) = K;
  nodes.stiffness.diagonal(1).setConstant(-K);
  nodes.stiffness.diagonal(-1).setConstant(-K);
  const MatrixXd inner = nodes.stiffness.block(1, 1, K - 1, K - 1);
  nodes.inverse_root = Eigen::SelfAdjointEigenSolver<MatrixXd>(inner).operatorInverseSqrt();
  return nodes;
}

MatrixXd interpolation(const VectorXd& from, const VectorXd& to) {
  MatrixXd L = MatrixXd::Ones(to.size(), from.size());
  for (Index i = 0; i < to.size(); ++i)
    for (Index j = 0; j < from.size(); ++j)
      for (Index k = 0; k < from.size(); ++k)
        if (k != j) L(i, j) *= (to(i) - from(k)) / (from(j) - from(k));
  return L;
}

}  // namespace stiefel
