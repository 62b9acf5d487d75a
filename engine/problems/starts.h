#pragma once

#include <cstdint>

#include "engine/problems/path.h"

namespace stiefel {

/// Paths of K steps to relax, the direct one first, from Q_0 to Q_T.
///
/// n ≥ N − 1: the frames are rotations, once a missing row is filled in: Q_0 exp(sW) with W =
/// log(Q_0ᵀQ_T), then W with one plane's angle θ taken as θ ∓ 2π, for every plane: never polar
/// factors, whose paths leave det = 1 at n = N. n < N − 1: the polar factors of (1−s)Q_0 + sQ_T,
/// bent where that is nearly singular. Then `restarts` paths through a random frame, both halves
/// built like this.
std::vector<Path> starts(const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T, int K,
                         int restarts, std::uint64_t seed);

}  // namespace stiefel
