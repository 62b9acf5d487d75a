#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/body/psi.h"

namespace stiefel {

/// Returns the power of two ε with ½ < ε·norm ≤ 1, for norm ≥ 0. Returns the largest power of two
/// for a denormal norm, and 1 for 0, infinity and NaN.
template <class Scalar>
Scalar unit_epsilon_of(Scalar norm) {
  using std::frexp, std::ldexp, std::isfinite;
  constexpr int largest = std::numeric_limits<Scalar>::max_exponent - 1;
  if (!isfinite(norm) || norm == 0) return 1;
  int exponent = 0;
  const Scalar digits = frexp(norm, &exponent);  // norm = digits·2^exponent, ½ ≤ digits < 1
  return ldexp(Scalar(1), std::min(largest, digits == Scalar(0.5) ? 1 - exponent : -exponent));
}

/// Returns the scaling ε of [RB] Prop. 3.13, where P belongs to εM and Ω = J⁻¹(QᵀP − PᵀQ)/ε: the
/// power of two with ½ < ε‖M‖_op ≤ 1, so that εM has the digits of M. A large M then has a P, and
/// the condition of Ψ⁻¹ is at most 2/√3. P holds all digits of a small M; with ε = 1 the error
/// would be 2⁻⁵³/‖M‖_op.
template <class Scalar>
Scalar unit_epsilon(const Matrix<Scalar>& M) {
  return unit_epsilon_of(skew_norm(M));
}

}  // namespace stiefel
