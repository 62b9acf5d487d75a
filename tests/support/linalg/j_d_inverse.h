#pragma once

#include "engine/dense/decompositions.h"
#include "engine/numbers/scalar.h"

namespace stiefel::testing {

/// Returns the U near the identity with UΛ − ΛUᵀ = K, in any scalar and without the engine's
/// solvers of it: U = (I − C)⁻¹(I + C), with C by Newton's method for ΛC + CΛ = ½(I − C)K(I + C)
/// and its explicit Jacobian on so(N).
template <class Scalar>
Matrix<Scalar> J_D_inverse(const Vector<Scalar>& lambda, const Matrix<Scalar>& K) {
  const Eigen::Index N = K.cols(), size = N * (N - 1) / 2;
  const Matrix<Scalar> I = Matrix<Scalar>::Identity(N, N);
  Matrix<Scalar> C = Matrix<Scalar>::Zero(N, N), Jacobian(size, size);
  const auto coordinates = [&](const Matrix<Scalar>& A) {
    Vector<Scalar> a(size);
    for (Eigen::Index j = 0, k = 0; j < N; ++j)
      for (Eigen::Index i = 0; i < j; ++i) a(k++) = A(i, j);
    return a;
  };
  const auto matrix = [&](const Vector<Scalar>& a) {
    Matrix<Scalar> A = Matrix<Scalar>::Zero(N, N);
    for (Eigen::Index j = 0, k = 0; j < N; ++j)
      for (Eigen::Index i = 0; i < j; ++i, ++k) A(i, j) = a(k), A(j, i) = -a(k);
    return A;
  };
  for (int iteration = 0; iteration < 12; ++iteration) {
    const Matrix<Scalar> F =
        lambda.asDiagonal() * C + C * lambda.asDiagonal() - (I - C) * K * (I + C) / 2;
    for (Eigen::Index k = 0; k < size; ++k) {
      const Matrix<Scalar> E = matrix(Vector<Scalar>::Unit(size, k));
      Jacobian.col(k) = coordinates(lambda.asDiagonal() * E + E * lambda.asDiagonal() +
                                    (E * K * (I + C) - (I - C) * K * E) / 2);
    }
    C -= matrix(Lu<Scalar>(Jacobian).solve(coordinates(F)));
  }
  return Lu<Scalar>(I - C).solve(I + C);
}

}  // namespace stiefel::testing
