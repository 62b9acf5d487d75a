#pragma once

#include <Eigen/Core>

namespace stiefel::testing {

/// Two blocks by rows.
template <class Top, class Bottom>
Eigen::MatrixX<typename Top::Scalar> stacked(const Eigen::MatrixBase<Top>& top,
                                             const Eigen::MatrixBase<Bottom>& bottom) {
  Eigen::MatrixX<typename Top::Scalar> x(top.rows() + bottom.rows(), top.cols());
  x << top, bottom;
  return x;
}

}  // namespace stiefel::testing
