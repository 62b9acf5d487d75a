#pragma once

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// Ω = J⁻¹(G − Gᵀ)/ε for any square G, that is Ω_ij = (G_ij − G_ji) / (ε(λ_i + λ_j)), exactly skew.
/// λ_i + λ_j > 0 for i ≠ j. Ω is not G.
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

/// [J(Ω), Ω] = [Λ, Ω²], that is (λ_i − λ_j)(Ω²)_ij: [M, Ω] with none of its cancellation, which
/// where Λ is spread wide, or λ_i next to λ_j, leaves nothing of it. Exactly skew. Ω is not the
/// result.
template <class Scalar, class Algebra, class Result>
void inertia_bracket(const Vector<Scalar>& lambda, const Eigen::MatrixBase<Algebra>& Omega,
                     Eigen::MatrixBase<Result>&& bracket) {
  bracket.noalias() = Omega * Omega;
  for (Eigen::Index j = 0; j < Omega.cols(); ++j) {
    bracket(j, j) = 0;
    for (Eigen::Index i = 0; i < j; ++i) {
      bracket(i, j) *= lambda(i) - lambda(j);
      bracket(j, i) = -bracket(i, j);
    }
  }
}

/// J_D(U) = UΛ − ΛUᵀ, which is hM where U = Q_kᵀQ_{k+1}; [RB] (4.7).
template <class Scalar>
Matrix<Scalar> J_D(const Vector<Scalar>& lambda, const Matrix<Scalar>& U) {
  const Matrix<Scalar> W = U * lambda.asDiagonal();
  return W - W.transpose();
}

/// X ← X − Xᵀ for a square block, exactly skew.
template <class Block>
void take_twice_skew_part(Block&& X) {
  for (Eigen::Index j = 0; j < X.cols(); ++j) {
    X(j, j) = 0;
    for (Eigen::Index i = 0; i < j; ++i) {
      X(i, j) -= X(j, i);
      X(j, i) = -X(i, j);
    }
  }
}

}  // namespace stiefel
