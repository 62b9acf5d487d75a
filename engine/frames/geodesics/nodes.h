#pragma once

#include <Eigen/Core>

namespace stiefel {

/// A discrete action of frames Q_k at the times t_k, k = 0, ..., K:
///
///     ½ Σ_kl S_kl tr(Q_kΛQ_lᵀ) ≈ ½ ∫₀¹ tr(ΛQ̇ᵀQ̇) dt .
struct Nodes {
  Eigen::VectorXd times, weights;  ///< K + 1 each; ∫f ≈ Σ w_k f(t_k)
  Eigen::MatrixXd stiffness;       ///< S, (K+1)²
  Eigen::MatrixXd inverse_root;    ///< S^{-1/2} of the inner nodes, (K−1)²
  Eigen::RowVectorXd start;        ///< Q̇(0) = Σ_k start_k Q_k

  Eigen::Index inner() const { return times.size() - 2; }
};

/// Returns Gauss, Lobatto and Legendre's nodes: S = DᵀWD with D the derivatives of the polynomial
/// through the Q_k, so that the error falls faster than every power of 1/K where the path is
/// smooth.
Nodes lobatto(int K);

/// Returns K + 1 equally spaced nodes: S is that of differences, the action of K steps of the
/// variational method of order 2.
Nodes equally_spaced(int K);

/// Returns the matrix that takes the values at `from` to those of their polynomial at `to`.
Eigen::MatrixXd interpolation(const Eigen::VectorXd& from, const Eigen::VectorXd& to);

}  // namespace stiefel
