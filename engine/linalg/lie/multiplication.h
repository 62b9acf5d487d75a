#pragma once

#include "engine/linalg/lie/exponential.h"
#include "engine/linalg/lie/so_n.h"
#include "engine/numbers/stoppable_product.h"

namespace stiefel {

/// SO(N) acting on N × N blocks stacked by rows, each multiplied from the right: X ↦ X exp Θ. All
/// blocks use the same exponential, so the product of one block with the transpose of another stays
/// constant.
template <class Scalar>
class RightMultiplication {
 public:
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

  explicit RightMultiplication(Eigen::Index N) : N_(N), exponential_(N), D_(N, N) {}

  Algebra zero() const { return Algebra::Zero(N_, N_); }
  static void velocity(const State& x, const Algebra& Omega, State& dx) {
    stoppable_product(x, Omega, dx);
  }
  static void bracket(const Algebra& a, const Algebra& b, Algebra& c) {
    SoN<Scalar>::bracket(a, b, c);
  }
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    exponential_(Theta, D_);
    stoppable_product(x, D_, dx);
  }

 private:
  Eigen::Index N_;
  SkewExponential<Scalar> exponential_;
  Matrix<Scalar> D_;
};

/// SO(N) acting on stacked N × N blocks from the left: X ↦ exp(Θ) X. A left action is a right
/// action of the opposite group, so the bracket is −[a, b].
template <class Scalar>
class LeftMultiplication {
 public:
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

  explicit LeftMultiplication(Eigen::Index N) : N_(N), exponential_(N), D_(N, N) {}

  Algebra zero() const { return Algebra::Zero(N_, N_); }
  static void velocity(const State& x, const Algebra& Omega, State& dx) {
    const Eigen::Index N = Omega.rows();
    for (Eigen::Index top = 0; top < x.rows(); top += N)
      stoppable_product(Omega, x.middleRows(top, N), dx.middleRows(top, N));
  }
  static void bracket(const Algebra& a, const Algebra& b, Algebra& c) {
    SoN<Scalar>::bracket(b, a, c);
  }
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    exponential_(Theta, D_);
    velocity(x, D_, dx);
  }
  /// Returns D = exp Θ − I of the last displacement.
  const Matrix<Scalar>& D() const { return D_; }

 private:
  Eigen::Index N_;
  SkewExponential<Scalar> exponential_;
  Matrix<Scalar> D_;
};

}  // namespace stiefel
