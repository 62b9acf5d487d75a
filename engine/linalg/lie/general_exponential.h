#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "engine/linalg/matrix_equations/decompositions.h"
#include "engine/numbers/scalar.h"
#include "engine/numbers/stoppable_product.h"

namespace stiefel {

/// Computes D = exp(A) − I for any real N × N matrix A, by the diagonal Padé approximant of degree
/// 7 with scaling and squaring (Higham 2005): r = (V − U)⁻¹(V + U), U odd and V even in A. D is
/// computed directly and doubled by exp(2A) − I = 2D + D², so it is relatively accurate for small
/// A. Allocates at construction only.
template <class Scalar>
class GeneralExponential {
 public:
  explicit GeneralExponential(Eigen::Index N);

  void operator()(const Matrix<Scalar>& A, Matrix<Scalar>& D);

 private:
  /// Returns the largest norm of A that the approximant accepts unscaled: Higham's bound, 0.95, for
  /// 53 bits. The error grows like the 14th power of the norm, which gives the bounds for other
  /// precisions.
  static Scalar largest_norm() {
    constexpr int digits = std::numeric_limits<Scalar>::digits;
    static const Scalar largest = static_cast<Scalar>(0.95 * std::exp2((53 - digits) / 14.0));
    return largest;
  }

  Matrix<Scalar> scaled_, square_, fourth_, sixth_, odd_, even_;
  Eigen::PartialPivLU<Matrix<Scalar>> lu_;
};

template <class Scalar>
GeneralExponential<Scalar>::GeneralExponential(Eigen::Index N)
    : scaled_(N, N), square_(N, N), fourth_(N, N), sixth_(N, N), odd_(N, N), even_(N, N), lu_(N) {}

template <class Scalar>
void GeneralExponential<Scalar>::operator()(const Matrix<Scalar>& A, Matrix<Scalar>& D) {
  static const std::array<Scalar, 8> b = {17297280, 8648640, 1995840, 277200, 25200, 1512, 56, 1};
  using std::isfinite;
  const Scalar norm = A.cwiseAbs().colwise().sum().maxCoeff();
  int doublings = 0;
  scaled_ = A;
  for (Scalar size = norm; size > largest_norm() && isfinite(size); size /= 2, ++doublings)
    scaled_ /= Scalar(2);

  stoppable_product(scaled_, scaled_, square_);
  stoppable_product(square_, square_, fourth_);
  stoppable_product(fourth_, square_, sixth_);
  even_ = b[7] * sixth_ + b[5] * fourth_ + b[3] * square_;
  even_.diagonal().array() += b[1];
  stoppable_product(scaled_, even_, odd_);
  even_ = b[6] * sixth_ + b[4] * fourth_ + b[2] * square_;
  even_.diagonal().array() += b[0];
  stop_point();
  lu_.compute(even_ - odd_);
  odd_ *= Scalar(2);
  stoppable_solve(lu_, odd_, D);
  for (int k = 0; k < doublings; ++k) {
    stoppable_product(D, D, odd_);
    D = Scalar(2) * D + odd_;
  }
}

// Compiled once, in exponential.cc.
extern template class GeneralExponential<double>;
extern template class GeneralExponential<long double>;

}  // namespace stiefel
