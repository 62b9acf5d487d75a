#pragma once

#include "engine/representations/outside_domain.h"

namespace stiefel {

/// Between (Q, M) and the (Q, P) with parameter μ, [RB] (8.5), Q ∈ GL(N), with the scaling of Prop.
/// 3.13, ε = 1 in the paper; for the discrete body, (8.10), μ/h stands for μ and ε = h gives the
/// paper's P. Everything is N × N:
///
///     Q⁻¹P − P⁻¹Q = ε(M + μΛ²),
///     P = Q(W + (I + W²)^{1/2}),   W = ½ε(M + μΛ²),   spec(I + W²) off (−∞, 0].
///
/// M = skew part of (Q⁻¹P − P⁻¹Q)/ε: μΛ² is symmetric. μ = 0: Ψ, for Q ∈ O(N).
Matrix<double> parametric_Psi(const Matrix<double>& Q, const Matrix<double>& P, double epsilon);

/// P. Outside the domain, "S_M^mu": the largest |w| of the eigenvalues iw of 2W on the imaginary
/// axis, which must be < 2.
MatrixWithin<double> parametric_Psi_inverse(const Vector<double>& lambda, const Matrix<double>& Q,
                                            const Matrix<double>& M, double mu, double epsilon);

/// How near the edge of that domain: the least |z| over the spectrum of I + W² in Re z > 0, the
/// least |Im z| elsewhere.
double margin_parametric(const Vector<double>& lambda, const Matrix<double>& M, double mu,
                         double epsilon);

/// 1/condition of M as a function of P: ε‖M‖_op/(‖G‖(1 + ‖G⁻¹‖²)), G = Q⁻¹P. P holds M to 2⁻⁵³
/// divided by this number: the digits of M go where ‖εM‖ ≪ 1 or ‖M‖ ≪ |μ|‖Λ‖².
double inverse_condition_parametric(const Matrix<double>& Q, const Matrix<double>& P,
                                    const Matrix<double>& M, double epsilon);

/// The power of two with ½ < ε(‖M‖_op + |μ|‖Λ‖²) ≤ 1: P then is well inside the domain.
double parametric_epsilon(const Vector<double>& lambda, const Matrix<double>& M, double mu);

}  // namespace stiefel
