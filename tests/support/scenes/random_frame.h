#pragma once

#include <Eigen/QR>
#include <cmath>
#include <random>

#include "engine/linalg/matrix_equations/symmetric_lyapunov.h"

namespace stiefel::testing {

/// A seeded state on V(n, N): Λ between 1 and `spread`, a random frame Q, and S = Q̇Λ for a random
/// tangent Q̇ with ‖Q̇‖_F = 1. Q̇ is tangent to rounding in the Scalar.
template <class Scalar>
struct RandomFrame {
  Vector<Scalar> lambda;
  Matrix<Scalar> Q, S;

  RandomFrame(int n, int N, unsigned seed, double spread = 4);

  Matrix<Scalar> state() const;
};

template <class Scalar>
RandomFrame<Scalar>::RandomFrame(int n, int N, unsigned seed, double spread)
    : lambda(N), Q(n, N), S(n, N) {
  std::mt19937_64 generator(seed);
  const auto uniform = [&] { return std::generate_canonical<double, 53>(generator); };
  for (Scalar& l : lambda) l = Scalar(std::pow(spread, uniform()));
  Matrix<Scalar> columns(N, n);
  for (Scalar& x : columns.reshaped()) x = Scalar(2 * uniform() - 1);
  Q = Matrix<Scalar>(Eigen::HouseholderQR<Matrix<Scalar>>(columns).householderQ() *
                     Matrix<Scalar>::Identity(N, n))
          .transpose();
  for (Scalar& x : S.reshaped()) x = Scalar(2 * uniform() - 1);
  const Vector<Scalar> inverse = lambda.cwiseInverse();
  for (int k = 0; k < 2; ++k) {  // S ← S − XQ, so that QΛ⁻¹Sᵀ + SΛ⁻¹Qᵀ = 0
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

// Compiled once, in random_frame.cc.
extern template struct RandomFrame<float>;
extern template struct RandomFrame<double>;
extern template struct RandomFrame<Quad>;

}  // namespace stiefel::testing
