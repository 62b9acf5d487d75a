#pragma once

#include "engine/linalg/scalar.h"

namespace stiefel {

/// max |QᵀQ − I|.
template <class Derived>
typename Derived::Scalar orthogonality_defect(const Eigen::MatrixBase<Derived>& Q) {
  using Scalar = typename Derived::Scalar;
  return (Q.transpose() * Q - Matrix<Scalar>::Identity(Q.cols(), Q.cols())).cwiseAbs().maxCoeff();
}

/// The orthogonal matrix nearest to an almost orthogonal Q, its polar factor: Q ← Q (3I − QᵀQ)/2
/// until the defect is at rounding level (Newton–Schulz; quadratic).
template <class Scalar>
Matrix<Scalar> nearest_orthogonal(Matrix<Scalar> Q) {
  const Matrix<Scalar> three = Scalar(3) * Matrix<Scalar>::Identity(Q.cols(), Q.cols());
  for (int k = 0; k < 3; ++k) Q = (Q * (three - Q.transpose() * Q) / Scalar(2)).eval();
  return Q;
}

}  // namespace stiefel
