#pragma once

#include <Eigen/Core>
#include <optional>

namespace stiefel {

/// A geodesic of the metric ‖Q̇‖² (Λ = I, the Euclidean metric) between two frames.
struct RoundGeodesic {
  Eigen::MatrixXd V;  ///< Q̇(0) for T = 1, n × N
  double residual;    ///< bound of max |Q(1) − Q_T|: the largest 2-norm of a row
};

/// Finds a geodesic from Q_0 to Q_T for Λ = I and n < N, by shooting in the span of both frames:
/// with K orthonormal rows that complete Q_0, n + p in all, p = min(n, N − n),
///
///     Q(t)ᵀ = [Q_0; K]ᵀ exp(tW) [I; 0] e^{−tA},   W = [[2A, −Bᵀ], [B, 0]],   V = −A Q_0 + BᵀK
///
/// (Edelman, Arias and Smith 1998). An iteration takes the miss at t = 1 back to t = 0 by
/// projections onto the tangent spaces at t = 1, 3/4, 1/2, 1/4 and 0 and subtracts it from (A, B)
/// (Zimmermann and Hüper 2022, "p-shooting"), and Anderson's method accelerates the iterations. It
/// takes 6 to 16 of them for lengths up to 0.8 π, and its work is proportional to
/// Nn² + (n + p)³. Returns nothing where the iterations do not converge, which only happens beyond
/// the injectivity radius, ‖V‖ = π, or next to it.
std::optional<RoundGeodesic> round_logarithm(const Eigen::MatrixXd& Q_0,
                                             const Eigen::MatrixXd& Q_T);

}  // namespace stiefel
