#pragma once

#include "engine/body/psi.h"
#include "engine/dense/decompositions.h"

/// Formulas of the rigid body that the engine does not need, for tests of those that it has. All
/// matrices are N × N.
namespace stiefel::testing {

/// Returns the M of (Q, Q̇): M = J(Ω) = ΛΩ + ΩΛ, Ω = QᵀQ̇; [RB] §2.
template <class Scalar>
Matrix<Scalar> M_of_Qdot(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                         const Matrix<Scalar>& Qdot) {
  const Matrix<Scalar> Omega = Q.transpose() * Qdot, product = Omega * lambda.asDiagonal();
  return product - product.transpose();
}

/// Returns the condition number of Ψ⁻¹, 1/(1 − (‖εM‖_op/2)²)^{1/2}: at the edge of the domain half
/// the digits are lost.
template <class Scalar>
double condition_Psi_inverse(const Matrix<Scalar>& M, Scalar epsilon = 1) {
  const double margin = margin_S_M(M, epsilon);
  return 2 / std::sqrt(margin * (4 - margin));
}

/// Returns εm_μ = P_μQ_μ⁻¹ − Q_μP_μ⁻¹, which is constant; [RB] after (8.6). P_μQ_μ⁻¹ is constant
/// too.
template <class Scalar>
Matrix<Scalar> parametric_spatial_momentum(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  const Matrix<Scalar> A = Lu<Scalar>(Q.transpose()).solve(P.transpose()).transpose();
  const Matrix<Scalar> B = Lu<Scalar>(P.transpose()).solve(Q.transpose()).transpose();
  return A - B;
}

}  // namespace stiefel::testing
