#pragma once

#include <complex>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Returns the Hamiltonian of the coupled double bracket, ¼⟨U, J_U U⟩ + ¼⟨V, J_V V⟩ with ⟨A, B⟩ = ½
/// tr(A†B), [RB] (5.6): the sum of ⅛ Σ |X_ij|²/(λ_i + λ_j) for X = PQ† − QP† with Λ_U and for X =
/// P†Q − Q†P with Λ_V. In the limits Λ_U → ∞ and Λ_V → ∞ it is half the rigid body's energy.
template <class Scalar>
Scalar double_bracket_hamiltonian(const Vector<Scalar>& lambda_u, const Vector<Scalar>& lambda_v,
                                  const Matrix<std::complex<Scalar>>& Q,
                                  const Matrix<std::complex<Scalar>>& P) {
  const auto term = [](const Vector<Scalar>& lambda, const Matrix<std::complex<Scalar>>& G) {
    Scalar sum = 0;
    for (Eigen::Index j = 0; j < G.cols(); ++j)
      for (Eigen::Index i = 0; i < G.rows(); ++i)
        sum += std::norm(G(i, j) - std::conj(G(j, i))) / (lambda(i) + lambda(j));
    return sum / 8;
  };
  return term(lambda_u, P * Q.adjoint()) + term(lambda_v, P.adjoint() * Q);
}

/// Returns the singular values of aQ + bP, p × q, in descending order, to an error of rounding
/// times the largest. They are constant for every a and b, because U(p) × U(q) acts on Q and P in
/// the same way. (a, b) = (1, 0) gives those of Q, (0, 1) those of P.
Vector<double> singular_values(const Matrix<std::complex<double>>& Q,
                               const Matrix<std::complex<double>>& P, std::complex<double> a,
                               std::complex<double> b);

}  // namespace stiefel
