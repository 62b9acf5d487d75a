#pragma once

#include <algorithm>
#include <vector>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// A matrix polynomial in μ: element j belongs to μʲ.
template <class Scalar>
using MatrixPolynomial = std::vector<Matrix<Scalar>>;

template <class Scalar>
void add_product(const MatrixPolynomial<Scalar>& a, const MatrixPolynomial<Scalar>& b,
                 std::size_t shift, MatrixPolynomial<Scalar>& sum) {
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) {
      while (sum.size() <= i + j + shift)
        sum.push_back(Matrix<Scalar>::Zero(a[0].rows(), a[0].rows()));
      sum[i + j + shift].noalias() += a[i] * b[j];
    }
}

/// Returns the coefficients of tr(L(μ)^k), k = 1..K, for a diagonal plus a matrix of low rank,
///
///     L(μ) = μᵈD + ZᵀW(μ)Z,   D = diag, N × N,   Z r × N,   W r × r, polynomial in μ,
///
/// in O(KN r²) operations and without an N × N matrix. With m_i = ZDⁱZᵀ, −∂_s log det(I − sL) gives
///
///     tr L^k = μᵈᵏ tr D^k + tr X_{k−1},
///     X_k = (k + 1) μᵈᵏ W m_k + Σ_{i=1}^{k} μ^{d(i−1)} W m_{i−1} X_{k−i}.
///
/// Element [k − 1][j] of the result belongs to μʲ in tr(L^k).
template <class Scalar>
std::vector<std::vector<Scalar>> power_traces(const Vector<Scalar>& D, int d,
                                              const Matrix<Scalar>& Z,
                                              const MatrixPolynomial<Scalar>& W, int K) {
  std::vector<MatrixPolynomial<Scalar>> X;
  MatrixPolynomial<Scalar> m;  // m_i, constant in μ
  std::vector<std::vector<Scalar>> traces;
  Matrix<Scalar> ZD = Z;
  Vector<Scalar> power = D;
  for (int k = 0; k < K; ++k) {
    m.push_back(ZD * Z.transpose());
    ZD = ZD * D.asDiagonal();
    MatrixPolynomial<Scalar> X_k;
    add_product(W, {Scalar(k + 1) * m.back()}, static_cast<std::size_t>(d * k), X_k);
    for (int i = 1; i <= k; ++i) {
      MatrixPolynomial<Scalar> inner;
      add_product({m[i - 1]}, X[k - i], 0, inner);
      add_product(W, inner, static_cast<std::size_t>(d * (i - 1)), X_k);
    }
    auto& trace = traces.emplace_back();
    for (const Matrix<Scalar>& coefficient : X_k) trace.push_back(coefficient.trace());
    const auto top = static_cast<std::size_t>(d * (k + 1));
    trace.resize(std::max(trace.size(), top + 1), Scalar(0));
    trace[top] += power.sum();
    power = power.cwiseProduct(D);
    X.push_back(std::move(X_k));
  }
  return traces;
}

}  // namespace stiefel
