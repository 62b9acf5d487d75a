#include "tests/extremes/bodies.h"

#include <cmath>
#include <random>

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"
#include "engine/dense/so_3.h"
#include "tests/support/scenes/rigid_forms.h"

namespace stiefel::extremes {
namespace {

std::vector<double> numbers(const Eigen::VectorXd& v) { return {v.begin(), v.end()}; }

}  // namespace

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index cols, unsigned seed) {
  std::mt19937_64 generator(seed);
  Eigen::MatrixXd A(rows, cols);
  for (double& x : A.reshaped()) x = 2 * std::generate_canonical<double, 53>(generator) - 1;
  return A;
}

Eigen::MatrixXd random_frame(Eigen::Index n, Eigen::Index N, unsigned seed) {
  Eigen::MatrixXd Q = orthonormal_columns(random_matrix(N, n, seed), n).transpose();
  if (n == N && determinant(Q) < 0) Q.row(0) = -Q.row(0);
  return Q;
}

double norm(const Eigen::MatrixXd& A) {
  const double size = A.cwiseAbs().maxCoeff();
  return size == 0 ? 0 : size * testing::operator_norm(A / size);
}

Eigen::VectorXd spread_inertia(int N, double spread) {
  Eigen::VectorXd lambda(N);
  for (int k = 0; k < N; ++k) lambda(k) = std::pow(spread, double(k) / (N - 1));
  return lambda;
}

SceneDescription rigid_body(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                            const Eigen::MatrixXd& M, double step) {
  SceneDescription d;
  d.system = "rigid_body";
  d.inertia = numbers(lambda);
  d.initial = {{"Q", RowMatrix(Q)}, {"M", RowMatrix(M)}};
  d.step = step;
  return d;
}

SceneDescription top(const Eigen::Vector3d& I, const Eigen::Vector3d& m, double step) {
  const Eigen::Vector3d lambda = Eigen::Vector3d::Constant(I.sum() / 2) - I;
  return rigid_body(lambda, random_frame(3, 3, 3), hat(m), step);
}

SceneDescription tumbling(const Eigen::VectorXd& lambda, double step, unsigned seed) {
  const Eigen::Index N = lambda.size();
  const Eigen::MatrixXd A = random_matrix(N, N, seed);
  Eigen::MatrixXd Omega = A - A.transpose();
  Omega /= norm(Omega);
  Eigen::MatrixXd M(N, N);
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < N; ++i) M(i, j) = (lambda(i) + lambda(j)) * Omega(i, j);
  return rigid_body(lambda, random_frame(N, N, seed + 1), M, step);
}

SceneDescription geodesic(Eigen::Index n, const Eigen::VectorXd& lambda, double step,
                          unsigned seed) {
  const Eigen::Index N = lambda.size();
  const Eigen::MatrixXd Q = random_frame(n, N, seed), A = random_matrix(n, N, seed + 1);
  const Eigen::MatrixXd AQ = A * Q.transpose();
  Eigen::MatrixXd Qdot = A - (AQ + AQ.transpose()) / 2 * Q;
  Qdot /= norm(Qdot);
  SceneDescription d;
  d.system = "stiefel";
  d.inertia = numbers(lambda);
  d.initial = {{"Q", RowMatrix(Q)}, {"S", RowMatrix(Qdot * lambda.asDiagonal())}};
  d.step = step;
  return d;
}

}  // namespace stiefel::extremes
