#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// States in single precision, for StoredAs.
template <class Wide_>
struct SinglePrecision {
  using Wide = Wide_;
  using Point = Eigen::Matrix<float, Wide::RowsAtCompileTime, Wide::ColsAtCompileTime>;
  static Point to_stored(const Wide& x) { return rounded_to<float>(x); }
  static Wide to_wide(const Point& x) { return x.template cast<double>(); }
};

}  // namespace stiefel
