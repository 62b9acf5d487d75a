#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/representations/psi.h"

namespace stiefel {

/// The power of two with ½ < ε·norm ≤ 1, norm ≥ 0: the largest there is for a denormal norm, 1 for
/// 0 and what is not finite.
template <class Scalar>
Scalar unit_epsilon_of(Scalar norm) {
  using std::frexp, std::ldexp, std::isfinite;
  constexpr int largest = std::numeric_limits<Scalar>::max_exponent - 1;
  if (!isfinite(norm) || norm == 0) return 1;
  int exponent = 0;
  const Scalar digits = frexp(norm, &exponent);  // norm = digits·2^exponent, ½ ≤ digits < 1
  return ldexp(Scalar(1), std::min(largest, digits == Scalar(0.5) ? 1 - exponent : -exponent));
}

/// The scaling of [RB] Prop. 3.13: Ω = J⁻¹(QᵀP − PᵀQ)/ε, P belonging to εM. The power of two with
/// ½ < ε‖M‖_op ≤ 1, so that εM has the very digits of M. A large M then has a P, by a Ψ⁻¹ that is
/// well conditioned (at most 2/√3); of a small M, P holds all digits, where with ε = 1 it holds
/// them to 2⁻⁵³/‖M‖_op.
template <class Scalar>
Scalar unit_epsilon(const Matrix<Scalar>& M) {
  return unit_epsilon_of(skew_norm(M));
}

/// P and the ε it belongs to.
template <class Scalar>
struct ScaledP {
  Matrix<Scalar> P;
  Scalar epsilon;
};

/// Ψ⁻¹ with the ε chosen for M. Refuses only what is not finite.
template <class Scalar>
WithinDomain<ScaledP<Scalar>> scaled_Psi_inverse(const Matrix<Scalar>& Q, const Matrix<Scalar>& M) {
  const Scalar epsilon = unit_epsilon(M);
  auto P = Psi_inverse(Q, M, epsilon);
  if (!P) return std::unexpected(P.error());
  return ScaledP<Scalar>{std::move(*P), epsilon};
}

}  // namespace stiefel
