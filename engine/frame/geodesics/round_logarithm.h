#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "engine/frame/geodesics/found.h"
#include "engine/frame/geodesics/frame_span.h"

namespace stiefel {

/// The metric of a search, and how far it goes:
///
///     ‖Q̇‖² = β tr(AAᵀ) + tr(HHᵀ),   Q̇ = AQ + H, HQᵀ = 0
///
/// (Hüper, Markina and Silva Leite 2021): β = 1 is the Euclidean metric, Λ = I, and β = 1/2 the
/// canonical one.
struct RoundSearch {
  double beta = 1;
  int restarts = 0;
  std::uint64_t seed = 0;
};

/// Finds a geodesic from Q_0 to Q_T, n < N, by shooting in the span of both frames: with K
/// orthonormal rows that complete Q_0, n + p in all, p = min(n, N − n),
///
///     Q(t)ᵀ = [Q_0; K]ᵀ exp(tW) [I; 0] e^{(1 − 2β)tA},   W = [[2βA, −Bᵀ], [B, 0]],
///     V = −A Q_0 + BᵀK
///
/// (Edelman, Arias and Smith 1998). An iteration takes the miss at t = 1 back to t = 0 by
/// projections onto the tangent spaces at t = 1, 3/4, 1/2, 1/4 and 0 and subtracts it from (A, B)
/// (Zimmermann and Hüper 2022, "p-shooting"), and Anderson's method accelerates the iterations. It
/// takes 6 to 16 of them for lengths up to 0.8 π, and its work is proportional to
/// Nn² + (n + p)³.
///
/// Where the length is not within a proved bound of the injectivity radius, it also searches from
/// Q_T to Q_0, and where one of the two does not converge, shortens a broken geodesic: so the
/// shortest length that it finds does not depend on the order of the frames. `restarts` further
/// searches start from random velocities of `seed`. The shortest geodesic counts, which is called
/// the shortest of all where that bound says so, else unknown. The residual is the largest 2-norm
/// of a row of Q(1) − Q_T. `best`, empty at first, is the shortest so far at any time.
void round_logarithm(const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T,
                     const FrameProducts& products, const RoundSearch& search, Found& best);

}  // namespace stiefel
