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
/// The blocks of two square ones.
inline Eigen::MatrixXd top(const Eigen::MatrixXd& x) { return x.topRows(x.cols()); }
inline Eigen::MatrixXd bottom(const Eigen::MatrixXd& x) { return x.bottomRows(x.cols()); }

}  // namespace stiefel::testing
