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

/// Invariants on V(n, N). Frames and S are n × N. Nothing here is N × N.

/// Returns E = ½ tr(SΛ⁻¹Sᵀ), S = Q̇Λ.
template <class Scalar, class Lambda, class Frame>
Scalar stiefel_energy(const Lambda& lambda, const Frame& S) {
  Scalar E = 0;
  for (Eigen::Index j = 0; j < S.cols(); ++j)
    E += S.col(j).template cast<Scalar>().squaredNorm() / Scalar(lambda(j));
  return E / 2;
}

/// Returns m_k = Q_kΛQ_{k−1}ᵀ − Q_{k−1}ΛQ_kᵀ; [ST] (57).
template <class Scalar>
Matrix<Scalar> discrete_momentum(const Vector<Scalar>& lambda, const Matrix<Scalar>& Q_prev,
                                 const Matrix<Scalar>& Q) {
  const Matrix<Scalar> product = Q * lambda.asDiagonal() * Q_prev.transpose();
  return product - product.transpose();
}

/// Returns the coefficients of tr L(μ)^k, k = 1..K, of the discrete Lax matrix [ST] (61),
///
///     L(μ) = Λ² + μM_k − μ²Q_{k−1}ᵀQ_{k−1},   M_k = Q_{k−1}ᵀQ_kΛ − ΛQ_kᵀQ_{k−1}.
///
/// The coefficients and the spectrum of L(μ) determine each other. Element [k − 1][j] belongs to
/// μʲ, j = 0..2k.
template <class Scalar>
std::vector<std::vector<Scalar>> discrete_lax_coefficients(const Vector<Scalar>& lambda,
                                                           const Matrix<Scalar>& Q_prev,
                                                           const Matrix<Scalar>& Q, int K) {
  const Eigen::Index n = Q.rows();
  const Matrix<Scalar> I = Matrix<Scalar>::Identity(n, n), O = Matrix<Scalar>::Zero(n, n);
  Matrix<Scalar> Z(2 * n, Q.cols()), constant(2 * n, 2 * n), linear(2 * n, 2 * n),
      quadratic(2 * n, 2 * n);
  Z << Q_prev, Q * lambda.asDiagonal();
  constant << O, O, O, O;
  linear << O, I, -I, O;
  quadratic << -I, O, O, O;
  return power_traces<Scalar>(lambda.cwiseAbs2(), 0, Z, {constant, linear, quadratic}, K);
}

/// Returns Joachimsthal's invariant of geodesics on the ellipsoid: (qᵀΛ⁻¹q)(q̇ᵀq̇).
template <class Scalar>
Scalar joachimsthal(const Vector<Scalar>& lambda, const Vector<Scalar>& q,
                    const Vector<Scalar>& qdot) {
  return q.cwiseAbs2().cwiseQuotient(lambda).sum() * qdot.squaredNorm();
}

/// Returns the coefficients of tr M(μ)^k, k = 1..K, of the Lax matrix [ST] (18) of (q, p),
///
///     M(μ) = qpᵀ − pqᵀ + μΛ + μ⁻¹ qqᵀ Δ/(qᵀΛ⁻¹q),   Δ = (pᵀΛ⁻¹q)² − (pᵀΛ⁻¹p)(qᵀΛ⁻¹q).
///
/// Element [k − 1][j] belongs to μ^{j−k}, j = 0..2k. p is any costate, for example Λq̇.
template <class Scalar>
std::vector<std::vector<Scalar>> lax_coefficients(const Vector<Scalar>& lambda,
                                                  const Vector<Scalar>& q, const Vector<Scalar>& p,
                                                  int K) {
  const Scalar qq = q.cwiseAbs2().cwiseQuotient(lambda).sum();
  const Scalar pp = p.cwiseAbs2().cwiseQuotient(lambda).sum();
  const Scalar qp = q.cwiseProduct(p).cwiseQuotient(lambda).sum();
  Matrix<Scalar> Z(2, q.size()), skew(2, 2), corner(2, 2);
  Z << q.transpose(), p.transpose();
  skew << 0, 1, -1, 0;
  corner << (qp * qp - pp * qq) / qq, 0, 0, 0;
  return power_traces<Scalar>(lambda, 2, Z, {corner, skew}, K);  // the traces of μM(μ)
}

}  // namespace stiefel
