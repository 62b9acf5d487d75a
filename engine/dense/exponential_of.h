#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "engine/dense/exponential.h"
#include "engine/numbers/stoppable_product.h"

namespace stiefel {

template <class Scalar>
Exponential<Scalar>::Exponential(Eigen::Index N, MatrixKind of)
    : of_(of),
      scaled_(N, N),
      square_(N, N),
      fourth_(N, N),
      sixth_(N, N),
      odd_(N, N),
      even_(N, N),
      lu_(N) {}

template <class Scalar>
void Exponential<Scalar>::operator()(const Matrix<Scalar>& A, Matrix<Scalar>& D) {
  static constexpr std::array<Scalar, 8> b = {17297280, 8648640, 1995840, 277200,
                                              25200,    1512,    56,      1};
  using std::isfinite, std::ldexp;
  // The largest norm of A that the approximant takes unscaled is Higham's bound for 53 bits. The
  // error grows like the 14th power of the norm, which gives the bounds for other precisions.
  static const Scalar largest =
      static_cast<Scalar>(0.95 * std::exp2((53 - std::numeric_limits<Scalar>::digits) / 14.0));
  int doublings = 0;
  for (Scalar norm = A.cwiseAbs().colwise().sum().maxCoeff(); norm > largest && isfinite(norm);
       norm /= 2)
    ++doublings;
  if (doublings > 0) scaled_ = ldexp(Scalar(1), -doublings) * A;
  const Matrix<Scalar>& scaled = doublings > 0 ? scaled_ : A;

  stoppable_product(scaled, scaled, square_);
  stoppable_product(square_, square_, fourth_);
  stoppable_product(fourth_, square_, sixth_);
  even_ = b[7] * sixth_ + b[5] * fourth_ + b[3] * square_;
  even_.diagonal().array() += b[1];
  stoppable_product(scaled, even_, odd_);
  even_ = b[6] * sixth_ + b[4] * fourth_ + b[2] * square_;
  even_.diagonal().array() += b[0];
  stop_point();
  even_ -= odd_;
  lu_.factor(even_);
  odd_ *= Scalar(2);
  lu_.solve(odd_, D);
  for (int k = 0; k < doublings; ++k) {
    stoppable_product(D, D, odd_);
    D = Scalar(2) * D + odd_;
    if (of_ == MatrixKind::skew && (k % 4 == 3 || (k > 3 && k == doublings - 1)))
      restore_orthogonality(D);
  }
}

/// Projects I + D to the orthogonal matrices, with UᵀU − I = D + Dᵀ + DᵀD.
template <class Scalar>
void Exponential<Scalar>::restore_orthogonality(Matrix<Scalar>& D) {
  stoppable_product(D.transpose(), D, even_);
  even_ += D + D.transpose();
  odd_ = even_;
  add_stoppable_product(D, even_, odd_);
  D -= odd_ / 2;
}

}  // namespace stiefel
