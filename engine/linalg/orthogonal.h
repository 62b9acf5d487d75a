#pragma once

#include <Eigen/SVD>

#include "engine/linalg/scalar.h"

namespace stiefel {

/// max |QᵀQ − I|.
template <class Derived>
typename Derived::Scalar orthogonality_defect(const Eigen::MatrixBase<Derived>& Q) {
  using Scalar = typename Derived::Scalar;
  return (Q.transpose() * Q - Matrix<Scalar>::Identity(Q.cols(), Q.cols())).cwiseAbs().maxCoeff();
}

/// The orthogonal factor of the polar decomposition: the orthogonal matrix nearest to Q.
template <class Scalar>
Matrix<Scalar> nearest_orthogonal(const Matrix<Scalar>& Q) {
  const Eigen::BDCSVD<Matrix<Scalar>> svd(Q, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace stiefel
