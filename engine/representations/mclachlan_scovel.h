#pragma once

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// (Q, M) and the (Q, B) of McLachlan and Scovel, [RB] (5.5): B = QM, with QᵀB skew. N × N.
template <class Scalar>
Matrix<Scalar> B_of_M(const Matrix<Scalar>& Q, const Matrix<Scalar>& M) {
  return Q * M;
}

/// M = QᵀB, its skew part: that is what it is for a B that belongs to some M.
template <class Scalar>
Matrix<Scalar> M_of_B(const Matrix<Scalar>& Q, const Matrix<Scalar>& B) {
  const Matrix<Scalar> M = Q.transpose() * B;
  return (M - M.transpose()) / 2;
}

/// B = (P − QPᵀQ)/ε, from the symmetric representation without M.
template <class Scalar>
Matrix<Scalar> B_of_P(const Matrix<Scalar>& Q, const Matrix<Scalar>& P, Scalar epsilon = 1) {
  return (P - Q * (P.transpose() * Q)) / epsilon;
}

/// How far B is from belonging to a momentum: max |QᵀB + BᵀQ|.
template <class Scalar>
Scalar skewness_defect(const Matrix<Scalar>& Q, const Matrix<Scalar>& B) {
  const Matrix<Scalar> R = Q.transpose() * B;
  return (R + R.transpose()).cwiseAbs().maxCoeff();
}

}  // namespace stiefel
