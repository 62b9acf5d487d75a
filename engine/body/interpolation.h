#pragma once

#include "engine/body/discrete_pairs.h"

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
Matrix<Scalar> weight_ahead(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q,
                            const Matrix<Scalar>& P, const Matrix<Scalar>& Q_next) {
  return Q.transpose() * (P - Q_next * lambda.asDiagonal());
}

}  // namespace stiefel
