#pragma once

#include "engine/dense/so_4.h"

namespace stiefel {

/// Converts the state of a map from a point of Observables, and to one. Where they have the same
/// shape only the precision changes. A body whose scene has no Q has a point without it; the rows
/// of Q in its state, if there are any, are zero.
template <class State>
struct Coordinates {
  using Scalar = typename State::Scalar;

  static State of(const Eigen::MatrixXd& point) {
    if constexpr (State::RowsAtCompileTime == Eigen::Dynamic) {
      return rounded_to<Scalar>(point);
    } else {
      State x = State::Zero();
      const Matrix<Scalar> rounded = rounded_to<Scalar>(point);
      for (Eigen::Index i = 1; i <= rounded.size(); ++i)
        x(x.size() - i) = rounded(rounded.size() - i, 0);
      return x;
    }
  }
  static void write(const State& x, Eigen::MatrixXd& point) {
    const Eigen::Index above = x.rows() - point.rows();
    for (Eigen::Index j = 0; j < point.cols(); ++j)
      for (Eigen::Index i = 0; i < point.rows(); ++i)
        point(i, j) = static_cast<double>(x(above + i, j));
  }
};

/// The coordinates of So4: the point is Q over M, or M.
template <class Scalar, int size>
requires(size == 6 || size == 22) struct Coordinates<Eigen::Matrix<Scalar, size, 1>> {
  using State = Eigen::Matrix<Scalar, size, 1>;
  static constexpr int first = size - 6;  ///< where M starts

  static State of(const Eigen::MatrixXd& point) {
    Eigen::Matrix<double, size, 1> x = Eigen::Matrix<double, size, 1>::Zero();
    if (point.rows() == 8)
      if constexpr (first > 0) x.template head<first>() = point.topRows(4).reshaped();
    for (int k = 0; k < 6; ++k)
      x(first + k) = point(point.rows() - 4 + skew4_rows[k], skew4_columns[k]);
    return rounded_to<Scalar>(x);
  }
  static void write(const State& x, Eigen::MatrixXd& point) {
    const Eigen::Index top = point.rows() - 4;
    if (top > 0)
      if constexpr (first > 0)
        point.topRows(4).reshaped() = x.template head<first>().template cast<double>();
    for (int k = 0; k < 6; ++k) {
      const int i = skew4_rows[k], j = skew4_columns[k];
      point(top + i, j) = x(first + k);
      point(top + j, i) = -x(first + k);
    }
  }
};

}  // namespace stiefel
