#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/dense/decompositions.h"
#include "engine/motion/outside_domain.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Ψ and Ψ⁻¹ between the symmetric representation (Q, P) and the rigid body (Q, M); [RB] (3.1),
/// Prop. 3.6, 3.11. All matrices are N × N; ε is the scaling of Prop. 3.13, 1 in the paper:
///
///     Ψ:    M = (QᵀP − PᵀQ)/ε,
///     Ψ⁻¹:  P = Q exp(asinh(εM/2)) = Q(εM/2 + (I + ε²M²/4)^{1/2}),   ‖εM‖_op < 2.
///
/// S = {‖QᵀP − PᵀQ‖_op < 2}, S_M its image. Ψ is one to one only on the part of S where spec(QᵀP)
/// lies in Re > 0: both P = Q and P = −Q belong to M = 0.
template <class Scalar>
Matrix<Scalar> Psi(const Matrix<Scalar>& Q, const Matrix<Scalar>& P, Scalar epsilon = 1) {
  const Matrix<Scalar> R = Q.transpose() * P;
  return (R - R.transpose()) / epsilon;
}

/// Returns the margin of εM in S_M: 2 − ‖εM‖_op, negative outside.
template <class Scalar>
double margin_S_M(const Matrix<Scalar>& M, Scalar epsilon = 1) {
  using std::abs;
  return 2 - static_cast<double>(abs(epsilon) * skew_norm(M));
}

/// Returns the margin of (Q, P) in S: 2 − ‖QᵀP − PᵀQ‖_op.
template <class Scalar>
double margin_S(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return margin_S_M(Psi(Q, P));
}

/// Returns the smallest eigenvalue of ½(QᵀP + PᵀQ), which is the cosine of the largest angle of
/// QᵀP. When it is positive, Ψ⁻¹ of Ψ(Q, P) is P.
template <class Scalar>
double principal_cosine(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  const Matrix<Scalar> R = Q.transpose() * P, symmetric = (R + R.transpose()) / 2;
  return static_cast<double>(symmetric_eigenvalues(symmetric)(0));
}

/// Returns 1/condition of M as a function of P: ‖εM‖_op/2. P is of size 1, so it holds M with a
/// relative error of 2⁻⁵³ divided by this number.
template <class Scalar>
double inverse_condition_Psi(const Matrix<Scalar>& M, Scalar epsilon = 1) {
  using std::abs;
  return static_cast<double>(abs(epsilon) * skew_norm(M)) / 2;
}

/// Returns (I + A²)^{1/2} of a skew A, ‖A‖_op < 1. With iA = ZwZ†, w real, the root is Z(1 −
/// w²)^{1/2}Z†. It commutes with A to rounding for every ‖A‖_op < 1, so A + (I + A²)^{1/2} is
/// orthogonal.
template <class Scalar>
MatrixWithin<Scalar> root_of_one_plus_square(const Matrix<Scalar>& A) {
  using std::sqrt;
  if (!A.allFinite())
    return std::unexpected(OutsideDomain{"S_M", std::numeric_limits<double>::infinity(), 2});
  const auto [w, X, Y] = skew_eigen(A);
  Vector<Scalar> root(w.size());
  for (Eigen::Index i = 0; i < w.size(); ++i) {
    if (!(w(i) < 1 && w(i) > -1))
      return std::unexpected(
          OutsideDomain{"S_M", 2 * static_cast<double>(w.cwiseAbs().maxCoeff()), 2});
    root(i) = sqrt((1 - w(i)) * (1 + w(i)));
  }
  stop_point(2 * static_cast<double>(A.rows() * A.size()));
  return Matrix<Scalar>(X * root.asDiagonal() * X.transpose() +
                        Y * root.asDiagonal() * Y.transpose());
}

/// Returns exp(asinh(A)) = A + (I + A²)^{1/2}.
template <class Scalar>
MatrixWithin<Scalar> exp_asinh(const Matrix<Scalar>& A) {
  auto root = root_of_one_plus_square(A);
  if (root) *root += A;
  return root;
}

template <class Scalar>
MatrixWithin<Scalar> Psi_inverse(const Matrix<Scalar>& Q, const Matrix<Scalar>& M,
                                 Scalar epsilon = 1) {
  auto E = exp_asinh<Scalar>(epsilon * M / 2);
  if (E) *E = (Q * *E).eval();
  return E;
}

/// Returns A = PQᵀ, constant along every motion of the symmetric representation; [RB] (8.2). Its
/// skew part is εm/2. In the right-invariant form the constant is Q_rᵀP_r = A(Q_rᵀ, P_rᵀ)ᵀ.
template <class Scalar>
Matrix<Scalar> constant_A(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return P * Q.transpose();
}

/// Returns the power of two ε with ½ < ε·norm ≤ 1, for norm ≥ 0. Returns the largest power of two
/// for a denormal norm, and 1 for 0, infinity and NaN.
template <class Scalar>
Scalar unit_epsilon_of(Scalar norm) {
  using std::frexp, std::ldexp, std::isfinite;
  constexpr int largest = std::numeric_limits<Scalar>::max_exponent - 1;
  if (!isfinite(norm) || norm == 0) return 1;
  int exponent = 0;
  const Scalar digits = frexp(norm, &exponent);  // norm = digits·2^exponent, ½ ≤ digits < 1
  return ldexp(Scalar(1), std::min(largest, digits == Scalar(0.5) ? 1 - exponent : -exponent));
}

/// Returns the scaling ε of [RB] Prop. 3.13, where P belongs to εM and Ω = J⁻¹(QᵀP − PᵀQ)/ε: the
/// power of two with ½ < ε‖M‖_op ≤ 1, so that εM has the digits of M. A large M then has a P, and
/// the condition of Ψ⁻¹ is at most 2/√3. P holds all digits of a small M; with ε = 1 the error
/// would be 2⁻⁵³/‖M‖_op.
template <class Scalar>
Scalar unit_epsilon(const Matrix<Scalar>& M) {
  return unit_epsilon_of(skew_norm(M));
}

// Compiled once, in discrete_pairs.cc.
extern template double principal_cosine(const Matrix<double>& Q, const Matrix<double>& P);
extern template MatrixWithin<double> root_of_one_plus_square(const Matrix<double>& A);

}  // namespace stiefel
