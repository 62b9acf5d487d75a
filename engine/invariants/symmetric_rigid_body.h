#pragma once

#include <vector>

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// Returns M = (QᵀP − PᵀQ)/ε, the body momentum; [RB] (3.2).
template <class Scalar>
Matrix<Scalar> body_momentum(const Matrix<Scalar>& Q, const Matrix<Scalar>& P, Scalar epsilon) {
  return (Q.transpose() * P - P.transpose() * Q) / epsilon;
}

/// Returns A = PQᵀ, constant along every motion of the symmetric representation; [RB] (8.2). Its
/// skew part is εm/2. In the right-invariant form the constant is Q_rᵀP_r = A(Q_rᵀ, P_rᵀ)ᵀ.
template <class Scalar>
Matrix<Scalar> constant_A(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return P * Q.transpose();
}

/// Returns m_r = Q_rᵀM_rQ_r, the constant momentum of the right-invariant body; [RB] Prop. 2.1.
template <class Scalar>
Matrix<Scalar> right_momentum(const Matrix<Scalar>& Q, const Matrix<Scalar>& M) {
  return Q.transpose() * M * Q;
}

/// Returns the coefficients of μ^j in tr((M + μB)^k), j = 0..k, for square M and B: result[k][j], k
/// = 0..K.
template <class Scalar>
std::vector<std::vector<Scalar>> pencil_traces(const Matrix<Scalar>& M, const Matrix<Scalar>& B,
                                               int K) {
  const Eigen::Index N = M.cols();
  std::vector<Matrix<Scalar>> power = {Matrix<Scalar>::Identity(N, N)};
  std::vector<std::vector<Scalar>> coefficients = {{static_cast<Scalar>(static_cast<double>(N))}};
  for (int k = 1; k <= K; ++k) {  // (M + μB)^k = (M + μB)(M + μB)^{k−1}
    power.push_back(B * power.back());
    for (std::size_t j = power.size() - 2; j > 0; --j)
      power[j] = (M * power[j] + B * power[j - 1]).eval();
    power[0] = (M * power[0]).eval();
    auto& traces = coefficients.emplace_back();
    for (const auto& P : power) traces.push_back(P.trace());
  }
  return coefficients;
}

/// Returns the Manakov integrals in reduced form, [RB] (8.3): the coefficients of tr((A − Aᵀ +
/// μQΛ²Qᵀ)^k). With A = PQᵀ they belong to εM.
template <class Scalar>
std::vector<std::vector<Scalar>> reduced_manakov(const Vector<Scalar>& lambda,
                                                 const Matrix<Scalar>& Q, const Matrix<Scalar>& A,
                                                 int K) {
  const Vector<Scalar> squares = lambda.cwiseProduct(lambda);
  const Matrix<Scalar> inertia = Q * squares.asDiagonal() * Q.transpose();
  return pencil_traces<Scalar>(A - A.transpose(), inertia, K);
}

}  // namespace stiefel
