#pragma once

#include "engine/rigid_body/moser_veselov/discrete_pairs.h"

namespace stiefel {

/// P_k as an interpolation of two frames with symmetric weights, [RB] (7.15)–(7.21), in the paper's
/// variables (M is h times the physical momentum). All matrices are N × N.
///
///     Σ_k = Q_kᵀ(P_k + Q_{k−1}Λ)    (7.15)      P_k = Q_kΣ_k − Q_{k−1}Λ    (7.16)
///     Λ_k = Q_kᵀ(P_k − Q_{k+1}Λ)    (7.20)      P_k = Q_kΛ_k + Q_{k+1}Λ    (7.21)
///
/// They solve, with Ω = Q_kᵀQ_{k−1} and U = Q_kᵀQ_{k+1},
///
///     Σ_k² − ΛΩᵀΣ_k − Σ_kΩΛ + Λ² − I = 0      (7.17)
///     Λ_k² + ΛUᵀΛ_k + Λ_kUΛ + Λ² − I = 0      (7.19), where the paper has U for Uᵀ.
template <class Scalar>
Matrix<Scalar> weight_behind(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q_previous,
                             const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return Q.transpose() * (P + Q_previous * lambda.asDiagonal());
}
template <class Scalar>
Matrix<Scalar> P_from_behind(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q_previous,
                             const Matrix<Scalar>& Q, const Matrix<Scalar>& Sigma) {
  return Q * Sigma - Q_previous * lambda.asDiagonal();
}
template <class Scalar>
Matrix<Scalar> weight_ahead(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                            const Matrix<Scalar>& P, const Matrix<Scalar>& Q_next) {
  return Q.transpose() * (P - Q_next * lambda.asDiagonal());
}
template <class Scalar>
Matrix<Scalar> P_from_ahead(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                            const Matrix<Scalar>& Q_next, const Matrix<Scalar>& Lambda_k) {
  return Q * Lambda_k + Q_next * lambda.asDiagonal();
}

/// Solves (7.17), [RB]'s second way to ψ: Σ_k = (I + M²/4)^{1/2} + ½(ΩΛ + ΛΩᵀ), M = ΛΩᵀ − ΩΛ,
/// ‖M‖_op < 2.
template <class Scalar>
MatrixWithin<Scalar> solve_weight_behind(const Vector<Scalar>& lambda,
                                         const Matrix<Scalar>& Q_previous,
                                         const Matrix<Scalar>& Q) {
  const Matrix<Scalar> W = Q.transpose() * Q_previous * lambda.asDiagonal();
  auto Sigma = root_of_one_plus_square<Scalar>((W.transpose() - W) / 2);
  if (!Sigma) return std::unexpected(OutsideDomain{"S_L", Sigma.error().value, 2});
  *Sigma += (W + W.transpose()) / 2;
  return Sigma;
}

/// Solves (7.19): Λ_k = (I + M²/4)^{1/2} − ½(UΛ + ΛUᵀ), M = J_D(U). The trace of Λ_k is the
/// discrete Hamiltonian (7.18), (6.17).
template <class Scalar>
MatrixWithin<Scalar> solve_weight_ahead(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                                        const Matrix<Scalar>& Q_next) {
  const Matrix<Scalar> W = Q.transpose() * Q_next * lambda.asDiagonal();
  auto Lambda_k = root_of_one_plus_square<Scalar>((W - W.transpose()) / 2);
  if (!Lambda_k) return std::unexpected(OutsideDomain{"S_L", Lambda_k.error().value, 2});
  *Lambda_k -= (W + W.transpose()) / 2;
  return Lambda_k;
}

}  // namespace stiefel
