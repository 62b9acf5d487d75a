#pragma once

#include "engine/body/psi.h"
#include "engine/dense/inertia_operator.h"
#include "engine/motion/outside_domain.h"

namespace stiefel {

// Maps between the discrete representations of Moser–Veselov, [RB] §7, n = N: two consecutive
// frames (Q_{k−1}, Q_k), the frame with the momentum (Q_k, M_k), and (Q_k, P_k). M is the physical
// momentum and h the step. The paper's M is hM, so h = 1 gives the printed formulas, and P belongs
// to hM (ε = h).

/// Returns M_k of two frames, Σ_L of (7.4), (7.11): hM_k = UᵀJ_D(U)U = ΛU − UᵀΛ, U = Q_{k−1}ᵀQ_k.
/// Defined for every pair.
template <class Scalar>
Matrix<Scalar> Sigma_L(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q_previous,
                       const Matrix<Scalar>& Q, Scalar h = 1) {
  const Matrix<Scalar> W = lambda.asDiagonal() * (Q_previous.transpose() * Q);
  return (W - W.transpose()) / h;
}

/// Returns 1/condition of M as a function of two frames: h‖M‖_op/(2 max|λ|). The frames hold M with
/// a relative error of 2⁻⁵³ divided by this number; for small h‖Ω‖ the two frames are close and the
/// number is small.
inline double inverse_condition_Sigma_L(const Vector<double>& lambda, const Matrix<double>& M,
                                        double h) {
  return std::abs(h) * skew_norm(M) / (2 * lambda.cwiseAbs().maxCoeff());
}

/// Returns Q_{k−1} of (Q_k, M_k), Σ_L⁻¹: Q_{k−1} = Q_kJ_D⁻¹(−hM_k), since J_D(U_{k−1}ᵀ) = −hM_k. Of
/// the pairs that Σ_L maps to (Q, M), it is the one with spec(UΛ) in Re > 0.
MatrixWithin<double> Sigma_L_inverse(const Vector<double>& lambda, const Matrix<double>& Q,
                                     const Matrix<double>& M, double h = 1);

/// Returns P_k of two frames, ψ = Σ_H⁻¹∘Σ_L of (7.5): P_k = Q_k exp(asinh(hM_k/2)), for (Q_{k−1},
/// Q_k) ∈ S_L, where ‖J_D(Q_{k−1}ᵀQ_k)‖_op < 2. Σ_H is Ψ: hM_k = Q_kᵀP_k − P_kᵀQ_k.
template <class Scalar>
MatrixWithin<Scalar> psi(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q_previous,
                         const Matrix<Scalar>& Q) {
  auto P = Psi_inverse(Q, Sigma_L(lambda, Q_previous, Q));
  if (!P) return std::unexpected(OutsideDomain{"S_L", P.error().value, P.error().bound});
  return P;
}

/// Return the margin of U in D_L, and of (Q, QU) in S_L: 2 − ‖J_D(U)‖_op.
template <class Scalar>
double margin_D_L(const Vector<Scalar>& lambda, const Matrix<Scalar>& U) {
  return margin_S_M(J_D(lambda, U));
}
template <class Scalar>
double margin_S_L(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q_previous,
                  const Matrix<Scalar>& Q) {
  return margin_D_L<Scalar>(lambda, Q_previous.transpose() * Q);
}

/// Returns the distance of Ω_L from degeneracy at (Q, QU): the smallest |w_i + w_j|, i < j, over
/// the eigenvalues w of UΛ. A pair in S_L is in E_L where this distance is positive (W ↦ ΛWU + UᵀWΛ
/// on so(N) has the determinant ∏(w_i + w_j)); on the branch Re w > 0 it always is.
double margin_E_L(const Vector<double>& lambda, const Matrix<double>& U);

/// Returns U = J_D⁻¹(K), K = hM skew: UΛ − ΛUᵀ = K, [RB] (7.13), on the branch that starts at the
/// identity, spec(UΛ) in Re > 0. If the branch has no solution, the error holds ‖K‖_op and, as
/// bound, the largest ‖tK‖_op, 0 ≤ t ≤ 1, that has a solution, to 1e-3.
MatrixWithin<double> J_D_inverse(const Vector<double>& lambda, const Matrix<double>& K);

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
