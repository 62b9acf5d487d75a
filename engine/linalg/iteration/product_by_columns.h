#pragma once

#include <algorithm>

#include "engine/linalg/arithmetic/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Sets out = A·B in pieces of at least 8 columns and about 3·10⁷ operations, with a check for a
/// stop request before each: in extended and quadruple precision one product of large matrices
/// takes seconds. The bits are those of one product: Eigen's kernels sum every element over the
/// same blocks whatever the number of columns, as long as a piece begins at a multiple of 4 and is
/// not a vector.
template <class Left, class Right, class Out>
void product_by_columns(const Left& A, const Right& B, Out&& out) {
  constexpr double operations = 3e7;
  constexpr Eigen::Index least = 8;
  const auto of_column = static_cast<double>(std::max<Eigen::Index>(A.size(), 1));
  const auto paid = static_cast<Eigen::Index>(std::min(operations / of_column, 1e6));
  const Eigen::Index piece = std::max(least, paid / least * least);
  for (Eigen::Index j = 0, columns = 0; j < B.cols(); j += columns) {
    const Eigen::Index left = B.cols() - j;
    columns = left < 2 * piece ? left : piece;
    stop_point(of_column * static_cast<double>(columns));
    out.middleCols(j, columns).noalias() = A * B.middleCols(j, columns);
  }
}

}  // namespace stiefel
