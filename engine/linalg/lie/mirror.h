#pragma once

#include <algorithm>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Sets the elements below the diagonal of a square block to `sign` times those above it, tile by
/// tile, so that columns and rows stay in the cache.
template <class Block>
void mirror_upper(Block&& A, int sign = 1) {
  using Scalar = typename std::remove_cvref_t<Block>::Scalar;
  constexpr Eigen::Index tile = 16;
  const Eigen::Index N = A.cols();
  for (Eigen::Index j = 0; j < N; j += tile) {
    const Eigen::Index width = std::min(tile, N - j);
    for (Eigen::Index i = 0; i < j; i += tile)
      A.block(j, i, width, tile) = Scalar(sign) * A.block(i, j, tile, width).transpose();
    for (Eigen::Index l = j; l < j + width; ++l)
      for (Eigen::Index k = j; k < l; ++k) A(l, k) = Scalar(sign) * A(k, l);
  }
}

}  // namespace stiefel
