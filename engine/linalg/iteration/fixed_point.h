#pragma once

#include <Eigen/Cholesky>
#include <algorithm>

#include "engine/numbers/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Solves z = g(z) to rounding. Makes plain sweeps while each removes most of the error, and then
/// mixes the last few by Anderson's method (Anderson 1965; Walker and Ni 2011),
///
///     z ← g − Σ c_i Δg_i,   c = argmin ‖f − Σ c_i Δf_i‖,   f = g − z,
///
/// which converges for many g that are not contractions. Allocates at construction only.
template <class Scalar>
class FixedPoint {
 public:
  FixedPoint(Eigen::Index rows, Eigen::Index cols);

  /// Starts from the given z; `sweep(z, g)` sets g = g(z). Ends when the residual is at rounding
  /// level or stagnates just above it. Returns false, and leaves z undefined, if the iteration does
  /// not converge.
  template <class Sweep>
  bool solve(Matrix<Scalar>& z, Sweep&& sweep) {
    const Scalar unit = two_to<Scalar>(1 - bits<Scalar>), swift = Scalar(0.25), slow = Scalar(0.7);
    constexpr int most = 100;
    Scalar last = 0;
    bool mixing = false;
    for (int k = 0; k < most; ++k) {
      stop_point(20.0 * static_cast<double>(z.size()));
      sweep(z, g_);
      f_ = g_ - z;
      if (!((0 * f_).sum() == 0)) return false;  // an element is infinite or not a number
      const Scalar error = f_.cwiseAbs().maxCoeff(), size = g_.cwiseAbs().maxCoeff();
      const Scalar ratio = k == 0 ? slow : Scalar(error / last);
      const Scalar expected = mixing || ratio > slow ? slow : ratio;
      if (error * expected <= unit / 2 * size || (ratio > slow && error <= 16 * unit * size)) {
        z = g_;
        return true;
      }
      mixing = mixing || (k > 0 && ratio > swift);
      if (k > 0) {
        const Eigen::Index column = (k - 1) % depth_;
        dg_.col(column) = g_.reshaped() - last_g_.reshaped();
        df_.col(column) = f_.reshaped() - last_f_.reshaped();
      }
      last_g_.swap(g_);
      last_f_.swap(f_);
      z = last_g_;
      if (mixing) mix(z, std::min<Eigen::Index>(k, depth_));
      last = error;
    }
    return false;
  }

 private:
  static constexpr Eigen::Index most_columns = 5;
  using Small =
      Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, 0, most_columns, most_columns>;
  using SmallVector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1, 0, most_columns, 1>;

  /// Sets z ← z − Σ c_i Δg_i, with c from the normal equations of the Δf_i scaled to unit length.
  void mix(Matrix<Scalar>& z, Eigen::Index columns);

  Eigen::Index depth_;
  Matrix<Scalar> g_, f_, last_g_, last_f_, dg_, df_;
};

template <class Scalar>
FixedPoint<Scalar>::FixedPoint(Eigen::Index rows, Eigen::Index cols)
    : depth_(std::min(most_columns, rows * cols)),
      g_(rows, cols),
      f_(rows, cols),
      last_g_(rows, cols),
      last_f_(rows, cols),
      dg_(rows * cols, depth_),
      df_(rows * cols, depth_) {}

template <class Scalar>
void FixedPoint<Scalar>::mix(Matrix<Scalar>& z, Eigen::Index columns) {
  Small normal(columns, columns);
  SmallVector scale(columns), c(columns);
  for (Eigen::Index i = 0; i < columns; ++i) {
    const Scalar norm = df_.col(i).norm();
    scale(i) = norm > 0 ? Scalar(1 / norm) : Scalar(0);
  }
  for (Eigen::Index i = 0; i < columns; ++i) {
    stop_point();
    c(i) = scale(i) * df_.col(i).dot(last_f_.reshaped());
    for (Eigen::Index j = 0; j < columns; ++j)
      normal(i, j) = scale(i) * scale(j) * df_.col(i).dot(df_.col(j));
    normal(i, i) += two_to<Scalar>(8 - bits<Scalar>);
  }
  normal.ldlt().solveInPlace(c);
  for (Eigen::Index i = 0; i < columns; ++i) z.reshaped() -= (scale(i) * c(i)) * dg_.col(i);
}

// Compiled once, in matrix_equations/instances.cc.
extern template class FixedPoint<double>;

}  // namespace stiefel
