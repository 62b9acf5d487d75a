#pragma once

#include <Eigen/Core>

/// The work, in operations, of the pieces of a two-point search between n × N frames; the search
/// announces it to `stop_point` before each piece. Counts of products and of the iterations in a
/// piece, within about a factor of two of callgrind's.
namespace stiefel::connect_work {

/// Returns the degrees of freedom of a frame.
inline double degrees(Eigen::Index n, Eigen::Index N) {
  return static_cast<double>(n * N - n * (n + 1) / 2);
}

/// Returns the work of a product, or of a decomposition of an n × n matrix, for one frame.
inline double frame(Eigen::Index n, Eigen::Index N) {
  return 4000 + 30 * static_cast<double>(n * n * N);
}

/// Returns the work of sums over all numbers of a path of so many frames.
inline double sums(Eigen::Index frames, Eigen::Index n, Eigen::Index N) {
  return static_cast<double>(frames * (300 + 10 * n * N));
}

}  // namespace stiefel::connect_work
