#pragma once

#include <Eigen/QR>
#include <random>

#include "engine/linalg/arithmetic/quadruple.h"
#include "engine/linalg/arithmetic/scalar.h"
#include "engine/linalg/matrix_equations/lu.h"

namespace stiefel::testing {

/// Seeded random matrices of any scalar. Each number is a sum of two doubles, so that the digits
/// beyond double precision are not zeros.
template <class Scalar>
class RandomMatrices {
 public:
  explicit RandomMatrices(unsigned seed) : engine_(seed) {}

  Matrix<Scalar> matrix(Eigen::Index rows, Eigen::Index cols);
  Matrix<Scalar> skew(Eigen::Index N);
  /// Returns n orthonormal rows in R^N; for n = N the determinant is +1.
  Matrix<Scalar> frame(Eigen::Index n, Eigen::Index N);
  /// Returns N numbers between 1 and `spread`.
  Vector<Scalar> lambda(Eigen::Index N, double spread = 4);

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

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
  const Eigen::HouseholderQR<Matrix<Scalar>> qr(matrix(N, n));
  Matrix<Scalar> Q = qr.householderQ() * Matrix<Scalar>::Identity(N, n);
  if (n == N && Q.determinant() < 0) Q.col(0) *= Scalar(-1);
  return Q.transpose();
}

template <class Scalar>
Vector<Scalar> RandomMatrices<Scalar>::lambda(Eigen::Index N, double spread) {
  std::uniform_real_distribution<double> uniform(1, spread);
  Vector<Scalar> l(N);
  for (Eigen::Index i = 0; i < N; ++i) l(i) = Scalar(uniform(engine_));
  return l;
}

/// Returns the rows of `top` followed by those of `bottom`.
template <class Scalar>
Matrix<Scalar> stacked(const Matrix<Scalar>& top, const Matrix<Scalar>& bottom) {
  Matrix<Scalar> x(top.rows() + bottom.rows(), top.cols());
  x << top, bottom;
  return x;
}

// Compiled once, in random_matrices.cc.
extern template class RandomMatrices<double>;
extern template class RandomMatrices<long double>;
extern template class RandomMatrices<Quad>;

}  // namespace stiefel::testing
