#pragma once

#include "engine/dense/decompositions.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Computes exp(tA) of one skew A, n × n, for any t at the same cost: with iA = Z w Z†, w real,
/// exp(tA) = Z e^{−iwt} Z†, orthogonal to rounding for every t: with Z = X + iY it is the product
/// of [X cos wt + Y sin wt, Y cos wt − X sin wt] with [X Y]ᵀ. Does not allocate after construction.
template <class Scalar>
class SkewFlow {
 public:
  explicit SkewFlow(const Matrix<Scalar>& A);

  void operator()(Scalar t, Matrix<Scalar>& E);

 private:
  Matrix<Scalar> XY_, turned_;
  Vector<Scalar> w_;
};

template <class Scalar>
SkewFlow<Scalar>::SkewFlow(const Matrix<Scalar>& A) : XY_(A.rows(), 2 * A.rows()) {
  auto [w, X, Y] = skew_eigen(A);
  XY_ << X, Y;
  turned_ = XY_;
  w_ = std::move(w);
}

template <class Scalar>
void SkewFlow<Scalar>::operator()(Scalar t, Matrix<Scalar>& E) {
  using std::cos, std::sin;
  const Eigen::Index n = w_.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Scalar c = cos(w_(i) * t), s = sin(w_(i) * t);
    turned_.col(i) = c * XY_.col(i) + s * XY_.col(n + i);
    turned_.col(n + i) = c * XY_.col(n + i) - s * XY_.col(i);
  }
  stop_point(2 * static_cast<double>(n * n * n));
  E.noalias() = turned_ * XY_.transpose();
}

// Compiled once, in exponential.cc.
extern template class SkewFlow<double>;
extern template class SkewFlow<long double>;

}  // namespace stiefel
