#pragma once

#include "engine/dense/power_traces.h"

namespace stiefel {

/// Invariants on V(n, N). Frames, S and P are n × N; m, k and PQᵀ are n × n. Nothing here is N × N.

/// Returns E = ½ tr(SΛ⁻¹Sᵀ), S = Q̇Λ.
template <class Scalar>
Scalar stiefel_energy(const Vector<Scalar>& lambda, const Matrix<Scalar>& S) {
  Scalar E = 0;
  for (Eigen::Index j = 0; j < S.cols(); ++j) E += S.col(j).squaredNorm() / lambda(j);
  return E / 2;
}

/// Returns PQᵀ = ½(k + m), constant along (68)–(69) for every costate P.
template <class Scalar>
Matrix<Scalar> costate_product(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return P * Q.transpose();
}

/// Returns m = PQᵀ − QPᵀ, the spatial momentum; P is any costate, or S.
template <class Scalar>
Matrix<Scalar> frame_momentum(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  const Matrix<Scalar> product = costate_product(Q, P);
  return product - product.transpose();
}

/// Returns m_k = Q_kΛQ_{k−1}ᵀ − Q_{k−1}ΛQ_kᵀ; [ST] (57).
template <class Scalar>
Matrix<Scalar> discrete_momentum(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q_prev,
                                 const Matrix<Scalar>& Q) {
  const Matrix<Scalar> product = Q * lambda.asDiagonal() * Q_prev.transpose();
  return product - product.transpose();
}

/// Returns the coefficients of tr L(μ)^k, k = 1..K, of the discrete Lax matrix [ST] (61),
///
///     L(μ) = Λ² + μM_k − μ²Q_{k−1}ᵀQ_{k−1},   M_k = Q_{k−1}ᵀQ_kΛ − ΛQ_kᵀQ_{k−1}.
///
/// The coefficients and the spectrum of L(μ) determine each other. Element [k − 1][j] belongs to
/// μʲ, j = 0..2k.
template <class Scalar>
std::vector<std::vector<Scalar>> discrete_lax_coefficients(const Vector<Scalar>& lambda,
                                                           const Matrix<Scalar>& Q_prev,
                                                           const Matrix<Scalar>& Q, int K) {
  const Eigen::Index n = Q.rows();
  const Matrix<Scalar> I = Matrix<Scalar>::Identity(n, n), O = Matrix<Scalar>::Zero(n, n);
  Matrix<Scalar> Z(2 * n, Q.cols()), constant(2 * n, 2 * n), linear(2 * n, 2 * n),
      quadratic(2 * n, 2 * n);
  Z << Q_prev, Q * lambda.asDiagonal();
  constant << O, O, O, O;
  linear << O, I, -I, O;
  quadratic << -I, O, O, O;
  return power_traces<Scalar>(lambda.cwiseAbs2(), 0, Z, {constant, linear, quadratic}, K);
}

}  // namespace stiefel
