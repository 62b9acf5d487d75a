#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Sets Ω = J⁻¹(G − Gᵀ)/ε for any square G, that is Ω_ij = (G_ij − G_ji) / (ε(λ_i + λ_j)), exactly
/// skew. Needs λ_i + λ_j > 0 for i ≠ j. Ω and G must be different matrices.
template <class Scalar, class G, class Omega>
void inverse_inertia(const Vector<Scalar>& lambda, const Eigen::MatrixBase<G>& g, Scalar epsilon,
                     Eigen::MatrixBase<Omega>& omega) {
  for (Eigen::Index j = 0; j < g.cols(); ++j) {
    omega(j, j) = 0;
    for (Eigen::Index i = 0; i < j; ++i) {
      omega(i, j) = (g(i, j) - g(j, i)) / (epsilon * (lambda(i) + lambda(j)));
      omega(j, i) = -omega(i, j);
    }
  }
}

/// Sets Ω = J⁻¹(M), N × N: Ω_ij = M_ij/(λ_i + λ_j) for i ≠ j, Ω_ii = 0. Needs λ_i + λ_j > 0 for
/// i ≠ j. M is skew up to rounding; it may be the same matrix as Ω.
template <class Lambda, class M, class Omega>
void inverse_inertia(const Eigen::MatrixBase<Lambda>& lambda, const Eigen::MatrixBase<M>& m,
                     Omega&& omega) {
  using Scalar = typename Lambda::Scalar;
  for (Eigen::Index j = 0; j < m.cols(); ++j)
    for (Eigen::Index i = 0; i < m.rows(); ++i)
      omega(i, j) = i == j ? Scalar(0) : Scalar(m(i, j) / (lambda(i) + lambda(j)));
}
template <class Scalar>
Matrix<Scalar> inverse_inertia(const Vector<Scalar>& lambda, Matrix<Scalar> M) {
  inverse_inertia(lambda, M, M);
  return M;
}

/// Computes [J(Ω), Ω] = [Λ, Ω²] by its elements (λ_i − λ_j)(Ω²)_ij, which is [M, Ω] without
/// cancellation and exactly skew. MΩ − ΩM can lose all digits where Λ is spread wide or λ_i is
/// close to λ_j. Ω and the result must be different matrices.
template <class Scalar, class Algebra, class Result>
void inertia_bracket(const Vector<Scalar>& lambda, const Eigen::MatrixBase<Algebra>& Omega,
                     Eigen::MatrixBase<Result>&& bracket) {
  bracket.derived().noalias() = Omega.derived() * Omega.derived();
  for (Eigen::Index j = 0; j < Omega.cols(); ++j) {
    bracket(j, j) = 0;
    for (Eigen::Index i = 0; i < j; ++i) {
      bracket(i, j) *= lambda(i) - lambda(j);
      bracket(j, i) = -bracket(i, j);
    }
  }
}

/// Returns J_D(U) = UΛ − ΛUᵀ, equal to hM for U = Q_kᵀQ_{k+1}; [RB] (4.7).
template <class Scalar>
Matrix<Scalar> J_D(const Vector<Scalar>& lambda, const Matrix<Scalar>& U) {
  const Matrix<Scalar> W = U * lambda.asDiagonal();
  return W - W.transpose();
}

/// Return (A + Aᵀ)/2 and (A − Aᵀ)/2.
template <class Square>
typename Square::PlainObject symmetric_part(const Eigen::MatrixBase<Square>& A) {
  return (A + A.transpose()) / 2;
}
template <class Square>
typename Square::PlainObject skew_part(const Eigen::MatrixBase<Square>& A) {
  return (A - A.transpose()) / 2;
}

/// Replaces a square block X by X − Xᵀ, exactly skew.
template <class Block>
void subtract_transpose(Block&& X) {
  for (Eigen::Index j = 0; j < X.cols(); ++j) {
    X(j, j) = 0;
    for (Eigen::Index i = 0; i < j; ++i) {
      X(i, j) -= X(j, i);
      X(j, i) = -X(i, j);
    }
  }
}

}  // namespace stiefel
