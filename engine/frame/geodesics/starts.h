#pragma once

#include <cstdint>

#include "engine/frame/geodesics/path.h"

namespace stiefel {

/// Returns paths from Q_0 to Q_T at given times, from 0 to 1, to be relaxed, the direct one first.
///
/// n ≥ N − 1: the frames are rotations once a missing row is filled in. The paths are Q_0 exp(sW)
/// with W = log(Q_0ᵀQ_T), then W with the angle θ of one plane replaced by θ ∓ 2π, for every plane;
/// without restarts only where |θ| ≥ π/2.
/// Polar factors are not used, because their paths leave det = 1 at n = N. n < N − 1: the polar
/// factors of (1−s)Q_0 + sQ_T, bent where that matrix is nearly singular; where Λ is `wide`, also
/// the other way round, through the opposite of the middle of that path. In both cases `restarts`
/// paths through a random frame follow, whose halves are built in the same way.
std::vector<Path> starts(const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T,
                         const Eigen::VectorXd& times, int restarts, std::uint64_t seed, bool wide);

}  // namespace stiefel
