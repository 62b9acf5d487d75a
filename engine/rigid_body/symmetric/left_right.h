#pragma once

#include "engine/rigid_body/symmetric/psi.h"

namespace stiefel {

/// Maps between the left- and the right-invariant rigid body: Q_r = Qᵀ, M_r = −M ([RB] Prop. 2.1),
/// P_r = Pᵀ (Prop. 3.4). Each map is its own inverse. States are Q over M or Q over P, 2N × N.
template <class Scalar>
Matrix<Scalar> right_of_left_momentum(const Matrix<Scalar>& x) {
  const Eigen::Index N = x.cols();
  Matrix<Scalar> y(2 * N, N);
  y << x.topRows(N).transpose(), -x.bottomRows(N);
  return y;
}
template <class Scalar>
Matrix<Scalar> right_of_left_symmetric(const Matrix<Scalar>& x) {
  const Eigen::Index N = x.cols();
  Matrix<Scalar> y(2 * N, N);
  y << x.topRows(N).transpose(), x.bottomRows(N).transpose();
  return y;
}

/// The right-invariant Ψ: returns M_r = (P_rQ_rᵀ − Q_rP_rᵀ)/ε.
template <class Scalar>
Matrix<Scalar> Psi_right(const Matrix<Scalar>& Q, const Matrix<Scalar>& P, Scalar epsilon = 1) {
  const Matrix<Scalar> R = P * Q.transpose();
  return (R - R.transpose()) / epsilon;
}

/// The inverse of the right-invariant Ψ, [RB] (3.4): returns P_r = exp(asinh(εM_r/2)) Q_r,
/// ‖εM_r‖_op < 2.
template <class Scalar>
MatrixWithin<Scalar> Psi_right_inverse(const Matrix<Scalar>& Q, const Matrix<Scalar>& M,
                                       Scalar epsilon = 1) {
  auto E = exp_asinh<Scalar>(epsilon * M / 2);
  if (E) *E = (*E * Q).eval();
  return E;
}

}  // namespace stiefel
