#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Returns the B of McLachlan and Scovel, [RB] (5.5), from (Q, M): B = QM, with QᵀB skew. All
/// matrices are N × N.
template <class Scalar>
Matrix<Scalar> B_of_M(const Matrix<Scalar>& Q, const Matrix<Scalar>& M) {
  return Q * M;
}

/// Returns M as the skew part of QᵀB; QᵀB is skew for every B that belongs to a momentum.
template <class Scalar>
Matrix<Scalar> M_of_B(const Matrix<Scalar>& Q, const Matrix<Scalar>& B) {
  const Matrix<Scalar> M = Q.transpose() * B;
  return (M - M.transpose()) / 2;
}

/// Returns the distance of B from the matrices that belong to a momentum: max |QᵀB + BᵀQ|.
template <class Scalar>
Scalar skewness_defect(const Matrix<Scalar>& Q, const Matrix<Scalar>& B) {
  const Matrix<Scalar> R = Q.transpose() * B;
  return (R + R.transpose()).cwiseAbs().maxCoeff();
}

}  // namespace stiefel
