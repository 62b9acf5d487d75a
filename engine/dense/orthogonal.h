#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Returns max |QQᵀ − I|: how far the rows of Q, n × N, are from orthonormal.
template <class Derived>
typename Derived::Scalar orthogonality_defect(const Eigen::MatrixBase<Derived>& Q) {
  using Scalar = typename Derived::Scalar;
  return (Q * Q.transpose() - Matrix<Scalar>::Identity(Q.rows(), Q.rows())).cwiseAbs().maxCoeff();
}

/// Returns the frame nearest to an almost orthonormal Q, which is its polar factor, by three
/// iterations of Q ← (3I − QQᵀ)Q/2 (Newton–Schulz; quadratic convergence).
template <class Scalar>
Matrix<Scalar> nearest_orthogonal(Matrix<Scalar> Q) {
  const Matrix<Scalar> three = Scalar(3) * Matrix<Scalar>::Identity(Q.rows(), Q.rows());
  for (int k = 0; k < 3; ++k) Q = ((three - Q * Q.transpose()) * Q / Scalar(2)).eval();
  return Q;
}

/// Returns the frame that stands for a given Q, n × N: Q where its rows are orthonormal to
/// rounding, max |QQᵀ − I| ≤ 4Nu, else the frame nearest to it.
Matrix<double> repaired(const Matrix<double>& Q);

// Compiled once, in decompositions.cc.
extern template Matrix<double> nearest_orthogonal(Matrix<double> Q);

}  // namespace stiefel
