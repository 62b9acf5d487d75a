#include "tests/support/scenes/random_matrices.h"

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"

namespace stiefel::testing {

template <class Scalar>
Matrix<Scalar> RandomMatrices<Scalar>::matrix(Eigen::Index rows, Eigen::Index cols) {
  Matrix<Scalar> A(rows, cols);
  for (Eigen::Index j = 0; j < cols; ++j)
    for (Eigen::Index i = 0; i < rows; ++i)
      A(i, j) = Scalar(normal_(engine_)) + Scalar(normal_(engine_)) * Scalar(0x1p-53);
  return A;
}

template <class Scalar>
Matrix<Scalar> RandomMatrices<Scalar>::skew(Eigen::Index N) {
  const Matrix<Scalar> A = matrix(N, N);
  return A - A.transpose();
}

template <class Scalar>
Matrix<Scalar> RandomMatrices<Scalar>::frame(Eigen::Index n, Eigen::Index N) {
  Matrix<Scalar> Q = orthonormal_columns<Scalar>(matrix(N, n), n);
  if (n == N && determinant(Q.template cast<double>()) < 0) Q.col(0) *= Scalar(-1);
  return Q.transpose();
}

template <class Scalar>
Vector<Scalar> RandomMatrices<Scalar>::lambda(Eigen::Index N, double spread) {
  std::uniform_real_distribution<double> uniform(1, spread);
  Vector<Scalar> l(N);
  for (Eigen::Index i = 0; i < N; ++i) l(i) = Scalar(uniform(engine_));
  return l;
}

template class RandomMatrices<double>;
template class RandomMatrices<long double>;
template class RandomMatrices<Quad>;

}  // namespace stiefel::testing
