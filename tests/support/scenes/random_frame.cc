#include "tests/support/scenes/random_frame.h"

#include <cmath>
#include <random>
#include <type_traits>

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"

namespace stiefel::testing {

template <class Scalar>
RandomFrame<Scalar>::RandomFrame(int n, int N, unsigned seed, double spread)
    : lambda(N), Q(n, N), S(n, N) {
  std::mt19937_64 generator(seed);
  const auto uniform = [&] { return std::generate_canonical<double, 53>(generator); };
  for (Scalar& l : lambda) l = Scalar(std::pow(spread, uniform()));
  Matrix<Scalar> columns(N, n);
  for (Scalar& x : columns.reshaped()) x = Scalar(2 * uniform() - 1);
  using Wide = std::conditional_t<std::is_same_v<Scalar, float>, double, Scalar>;
  const Matrix<Wide> orthonormal = orthonormal_columns<Wide>(columns.template cast<Wide>(), n);
  Q = orthonormal.transpose().template cast<Scalar>();
  for (Scalar& x : S.reshaped()) x = Scalar(2 * uniform() - 1);
  const Vector<Scalar> inverse = lambda.cwiseInverse();
  for (int k = 0; k < 2; ++k) {  // S ← S − XQ with QΛ⁻¹Sᵀ + SΛ⁻¹Qᵀ = 0
    const Matrix<Scalar> weighted = Q * inverse.asDiagonal();
    const Matrix<Scalar> cross = weighted * S.transpose();
    SymmetricLyapunov<Scalar> lyapunov(n);
    lyapunov.factor(weighted * Q.transpose());
    Matrix<Scalar> X(n, n);
    lyapunov.solve(cross + cross.transpose(), X);
    S -= X * Q;
  }
  S /= (S * inverse.asDiagonal()).norm();
}

template <class Scalar>
Matrix<Scalar> RandomFrame<Scalar>::state() const {
  Matrix<Scalar> x(2 * Q.rows(), Q.cols());
  x << Q, S;
  return x;
}

template struct RandomFrame<double>;
template struct RandomFrame<long double>;
template struct RandomFrame<Quad>;

}  // namespace stiefel::testing
