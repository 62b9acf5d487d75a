#pragma once

#include "engine/dense/decompositions.h"
#include "engine/motion/outside_domain.h"

namespace stiefel {

/// Returns εM_μ = Q_μ⁻¹P_μ − P_μ⁻¹Q_μ, [RB] (8.5) and (8.10) with the scaling of Prop. 3.13. M_μ =
/// M + μΛ², where M must be skew. tr((εM_μ)^k) and every eigenvalue of εM_μ are constant.
template <class Scalar>
Matrix<Scalar> parametric_momentum(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return Lu<Scalar>(Q).solve(P) - Lu<Scalar>(P).solve(Q);
}

/// Maps between (Q, M) and the (Q, P) with parameter μ, [RB] (8.5), Q ∈ GL(N), with the scaling of
/// Prop. 3.13 (ε = 1 in the paper). For the discrete body, (8.10), replace μ by μ/h; ε = h gives
/// the paper's P. All matrices are N × N:
///
///     Q⁻¹P − P⁻¹Q = ε(M + μΛ²),
///     P = Q(W + (I + W²)^{1/2}),   W = ½ε(M + μΛ²),   spec(I + W²) off (−∞, 0].
///
/// M is the skew part of (Q⁻¹P − P⁻¹Q)/ε, because μΛ² is symmetric. For μ = 0 and Q ∈ O(N) this is
/// Ψ.
Matrix<double> parametric_Psi(const Matrix<double>& Q, const Matrix<double>& P, double epsilon);

/// Returns the P of (Q, M). Outside the domain "S_M^mu" the error holds the largest |w| over the
/// eigenvalues iw of 2W on the imaginary axis, which must be < 2.
MatrixWithin<double> parametric_Psi_inverse(const Vector<double>& lambda, const Matrix<double>& Q,
                                            const Matrix<double>& M, double mu, double epsilon);

/// Returns the margin in the domain S_M^mu: the smallest of |z| for the eigenvalues z of I + W²
/// with Re z > 0 and of |Im z| for the others.
double margin_parametric(const Vector<double>& lambda, const Matrix<double>& M, double mu,
                         double epsilon);

/// Returns 1/condition of M as a function of P: ε‖M‖_op/(‖G‖(1 + ‖G⁻¹‖²)), G = Q⁻¹P. P holds M with
/// a relative error of 2⁻⁵³ divided by this number: digits of M are lost where ‖εM‖ ≪ 1 or ‖M‖ ≪
/// |μ|‖Λ‖².
double inverse_condition_parametric(const Matrix<double>& Q, const Matrix<double>& P,
                                    const Matrix<double>& M, double epsilon);

/// Returns the power of two ε with ½ < ε(‖M‖_op + |μ|‖Λ‖²) ≤ 1: P is then well inside the domain.
double parametric_epsilon(const Vector<double>& lambda, const Matrix<double>& M, double mu);

}  // namespace stiefel
