#pragma once

#include <cmath>
#include <optional>

#include "engine/linalg/matrix_equations/inertia_operator.h"
#include "engine/rigid_body/body/body_invariants.h"

namespace stiefel {

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
