#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "engine/numbers/dense_product.h"

namespace stiefel {

template <class Scalar>
using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
template <class Scalar>
using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
template <class Scalar>
using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
using Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;
using Dense = MatrixXd;

/// The wider scalar in which compensated arithmetic computes a last residual and an increment. 11
/// more bits are enough, because the sums carry the rest.
template <class Scalar>
struct ExtendedOf {
  using type = Scalar;
};
template <>
struct ExtendedOf<float> {
  using type = double;
};
template <>
struct ExtendedOf<double> {
  using type = long double;
};
template <class Scalar>
using Extended = typename ExtendedOf<Scalar>::type;

/// Returns 2^k. `bits` is the number of bits of a Scalar. Thresholds are powers of two that follow
/// the precision.
template <class Scalar>
Scalar two_to(int k) {
  using std::ldexp;
  return ldexp(Scalar(1), k);
}
/// Returns the largest power of two that is not above x > 0. Numbers of the size of x, divided by
/// this unit, have products within the range of a Scalar, and the division changes no bit.
template <class Scalar>
Scalar binary_unit(const Scalar& x) {
  using std::frexp;
  int exponent = 0;
  frexp(x, &exponent);
  return two_to<Scalar>(exponent - 1);
}
template <class Scalar>
inline constexpr int bits = std::numeric_limits<Scalar>::digits;

/// Returns x in a precision that may be lower. Not inlined: the SLP vectoriser of g++ 12 at -O3
/// removes the rounding from double to float and back.
template <class Scalar, class Derived>
[[gnu::noinline]] Eigen::Matrix<Scalar, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime>
rounded_to(const Eigen::MatrixBase<Derived>& x) {
  return x.template cast<Scalar>();
}

}  // namespace stiefel
