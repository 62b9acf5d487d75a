#pragma once

#include <Eigen/Core>

#include "engine/frame/geodesics/path.h"

namespace stiefel {

/// A discrete action of frames Q_k at the times t_k, k = 0, ..., K:
///
///     ½ Σ_kl S_kl tr(Q_kΛQ_lᵀ) ≈ ½ ∫₀¹ tr(ΛQ̇ᵀQ̇) dt .
struct Nodes {
  Eigen::VectorXd times, weights;  ///< K + 1 each; ∫f ≈ Σ w_k f(t_k)
  Eigen::MatrixXd stiffness;       ///< S, (K+1)²
  Eigen::MatrixXd inverse_root;    ///< S^{-1/2} of the inner nodes, (K−1)²
  Eigen::RowVectorXd start;        ///< Q̇(0) = Σ_k start_k Q_k
  Eigen::VectorXd breaks = {};     ///< ends of the pieces on which the path is a polynomial

  Eigen::Index inner() const { return times.size() - 2; }
};

/// Returns Gauss, Lobatto and Legendre's nodes: S = DᵀWD with D the derivatives of the polynomial
/// through the Q_k, so that the error falls faster than every power of 1/K where the path is
/// smooth.
Nodes lobatto(int K);

/// Returns the nodes of `lobatto(K)` in each piece between `breaks`, which run from 0 to 1. A piece
/// shares its ends with its neighbours.
Nodes pieces(const Eigen::VectorXd& breaks, int K);

/// Returns K + 1 equally spaced nodes: S is that of differences, the action of K steps of the
/// variational method of order 2.
Nodes equally_spaced(int K);

/// Return the frames nearest to the polynomials of a path at other nodes, and the largest |QQᵀ − I|
/// of the polynomial of each piece half-way between its nodes, which tells how well the nodes
/// resolve the path.
Path moved(const Path& path, const Nodes& from, const Nodes& to);
Eigen::VectorXd defects(const Path& path, const Nodes& nodes);

}  // namespace stiefel
