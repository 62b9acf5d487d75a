#pragma once

#include "engine/linalg/arithmetic/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// out = A·B in pieces of 64 to 127 columns, with a look at the stop token before each: in extended
/// and quadruple precision one product of large matrices takes seconds. Eigen's kernels sum every
/// element over the same blocks whatever the number of columns, as long as a piece begins at a
/// multiple of 4 and is no vector, so the bits are those of one product.
template <class Left, class Right, class Out>
void product_by_columns(const Left& A, const Right& B, Out&& out) {
  constexpr Eigen::Index piece = 64;
  for (Eigen::Index j = 0, columns = 0; j < B.cols(); j += columns) {
    const Eigen::Index left = B.cols() - j;
    columns = left < 2 * piece ? left : piece;
    stop_point(static_cast<double>(A.rows() * A.cols() * columns));
    out.middleCols(j, columns).noalias() = A * B.middleCols(j, columns);
  }
}

}  // namespace stiefel
