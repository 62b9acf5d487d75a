#pragma once

#include <cmath>
#include <optional>
#include <stop_token>
#include <vector>

#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Returns E = ½ tr(ΛΩᵀΩ) = ½ Σ_{i<j} M_ij² / (λ_i + λ_j).
template <class Scalar>
Scalar energy(const Vector<Scalar>& lambda, const Matrix<Scalar>& M) {
  Scalar E = 0;
  for (Eigen::Index j = 0; j < M.cols(); ++j)
    for (Eigen::Index i = 0; i < j; ++i) E += M(i, j) * M(i, j) / (lambda(i) + lambda(j));
  return E / 2;
}

/// Returns m = QMQᵀ, the spatial momentum; [RB] Prop. 2.1.
template <class Scalar>
Matrix<Scalar> spatial_momentum(const Matrix<Scalar>& Q, const Matrix<Scalar>& M) {
  return Q * M * Q.transpose();
}

/// Returns the coefficients of μ^j in tr((M + μB)^k), j = 0..k, for a square M and a B of the same
/// size, which may be diagonal: result[k][j], k = 0..K. On a stop request returns the powers k
/// computed so far.
template <class Scalar, class Square>
std::vector<std::vector<Scalar>> pencil_traces(const Matrix<Scalar>& M, const Square& B, int K,
                                               const std::stop_token& stop = {}) {
  const Eigen::Index N = M.cols();
  std::vector<Matrix<Scalar>> power = {Matrix<Scalar>::Identity(N, N)};
  std::vector<std::vector<Scalar>> coefficients = {{static_cast<Scalar>(static_cast<double>(N))}};
  Matrix<Scalar> product(N, N);
  for (int k = 1; k <= K; ++k) {  // (M + μB)^k = (M + μB)(M + μB)^{k−1}
    power.push_back(B * power.back());
    for (std::size_t j = power.size() - 2; j > 0; --j) {
      if (stop.stop_requested()) return coefficients;
      stop_point(static_cast<double>(N * N * N));
      product.noalias() = M * power[j];
      power[j] = product + B * power[j - 1];
    }
    stop_point(static_cast<double>(N * N * N));
    product.noalias() = M * power[0];
    power[0] = product;
    auto& traces = coefficients.emplace_back();
    for (const auto& P : power) traces.push_back(P.trace());
  }
  return coefficients;
}

/// Returns the coefficients of μ^j in tr((M + μΛ²)^k) for j = 0..k; [RB] (2.4). They are 0 for odd
/// k − j. One call computes all k = 1..K: result[k][j]. N³K² operations. On a stop request returns
/// the powers k computed so far.
template <class Scalar>
std::vector<std::vector<Scalar>> manakov(const Vector<Scalar>& lambda, const Matrix<Scalar>& M,
                                         int K, const std::stop_token& stop = {}) {
  const Vector<Scalar> lambda2 = lambda.cwiseAbs2();
  return pencil_traces<Scalar>(M, lambda2.asDiagonal(), K, stop);
}

/// Returns the discrete Hamiltonian [RB] (6.17), tr exp(asinh(K/2)) − tr ΛU for K = hM and U =
/// J_D⁻¹(K). The first term is Σ √(1 − w²/4) over all eigenvalues ±iw of K; returns nullopt for
/// ‖K‖_op > 2, where it is not real.
template <class Scalar>
std::optional<Scalar> discrete_hamiltonian(const Vector<Scalar>& lambda, const Matrix<Scalar>& K,
                                           const Matrix<Scalar>& U) {
  using std::sqrt;
  Scalar H = static_cast<Scalar>(K.rows() % 2);
  for (const Scalar w : casimirs(K)) {
    if (w > 2) return std::nullopt;
    H += 2 * sqrt((1 - w / 2) * (1 + w / 2));
  }
  return H - lambda.dot(U.diagonal());
}

}  // namespace stiefel
