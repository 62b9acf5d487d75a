#pragma once

#include <array>
#include <cmath>

#include "engine/linalg/matrix_equations/decompositions.h"
#include "engine/numbers/scalar.h"
#include "engine/numbers/stoppable_product.h"

namespace stiefel {

/// Computes D = exp(Θ) − I for a skew N × N matrix Θ, by the diagonal Padé approximant of degree 7
/// with scaling and squaring (Higham 2005). r = (V − U)⁻¹(V + U), U odd and V even in Θ, is
/// orthogonal to rounding because Θ is skew. D is computed directly, so it is relatively accurate
/// for small Θ, and doubled by exp(2Θ) − I = 2D + D². Each doubling doubles the rounding error, so
/// some doublings are followed by the projection of U = I + D to the orthogonal matrices, U ← U(3I
/// − UᵀU)/2. Allocates at construction only.
template <class Scalar>
class SkewExponential {
 public:
  explicit SkewExponential(Eigen::Index N);

  void operator()(const Matrix<Scalar>& theta, Matrix<Scalar>& D);

 private:
  void restore_orthogonality(Matrix<Scalar>& D);

  Matrix<Scalar> square_, fourth_, sixth_, odd_, even_;
  Eigen::PartialPivLU<Matrix<Scalar>> lu_;
};

template <class Scalar>
SkewExponential<Scalar>::SkewExponential(Eigen::Index N)
    : square_(N, N), fourth_(N, N), sixth_(N, N), odd_(N, N), even_(N, N), lu_(N) {}

template <class Scalar>
void SkewExponential<Scalar>::operator()(const Matrix<Scalar>& theta, Matrix<Scalar>& D) {
  constexpr std::array<Scalar, 8> b = {17297280, 8648640, 1995840, 277200, 25200, 1512, 56, 1};
  constexpr Scalar largest_norm = Scalar(0.95);
  using std::ceil, std::exp2, std::log2;
  const Scalar norm = theta.cwiseAbs().colwise().sum().maxCoeff();
  const int doublings = norm > largest_norm ? static_cast<int>(ceil(log2(norm / largest_norm))) : 0;
  const Scalar scale = exp2(Scalar(-doublings));

  stoppable_product((scale * scale) * theta, theta, square_);
  stoppable_product(square_, square_, fourth_);
  stoppable_product(fourth_, square_, sixth_);
  even_ = b[7] * sixth_ + b[5] * fourth_ + b[3] * square_;
  even_.diagonal().array() += b[1];
  stoppable_product(scale * theta, even_, odd_);
  even_ = b[6] * sixth_ + b[4] * fourth_ + b[2] * square_;
  even_.diagonal().array() += b[0];
  stop_point();
  lu_.compute(even_ - odd_);
  odd_ *= Scalar(2);
  stoppable_solve(lu_, odd_, D);
  for (int k = 0; k < doublings; ++k) {
    stoppable_product(D, D, odd_);
    D = Scalar(2) * D + odd_;
    if (k % 4 == 3 || (k > 3 && k == doublings - 1)) restore_orthogonality(D);
  }
}

/// Projects I + D to the orthogonal matrices, with UᵀU − I = D + Dᵀ + DᵀD.
template <class Scalar>
void SkewExponential<Scalar>::restore_orthogonality(Matrix<Scalar>& D) {
  stoppable_product(D.transpose(), D, even_);
  even_ += D + D.transpose();
  odd_ = even_;
  add_stoppable_product(D, even_, odd_);
  D -= odd_ / 2;
}

// Compiled once, in exponential.cc.
extern template class SkewExponential<double>;
extern template class SkewExponential<long double>;

}  // namespace stiefel
