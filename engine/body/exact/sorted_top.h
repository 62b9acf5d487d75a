#pragma once

#include <array>
#include <cmath>
#include <utility>

#include "engine/dense/principal_moments_3.h"

namespace stiefel {

/// A free rigid body at time 0 along its principal axes, I₁ ≤ I₂ ≤ I₃, with the constants of its
/// motion: G = |m|, 2E = Σ m_i²/I_i and Δ_j = G² − 2E I_j, in a form in which only Δ₂ can cancel.
///
/// In Jacobi's solution m circles the first axis, (i, j, k) = (1, 2, 3), if Δ₂ < 0, else the third,
/// (3, 2, 1); on the separatrix Δ₂ = 0.
template <class Scalar>
struct SortedTop {
  using Vec = Vector3<Scalar>;
  std::array<int, 3> axis{0, 1, 2};  ///< the axes of the body in the order of their moments
  bool even = true;                  ///< whether this is an even permutation
  Vec I, m, Delta;
  Eigen::Matrix<Scalar, 3, 3> difference;  ///< I_j − I_k
  Scalar G, two_E;

  /// The differences of moments may be more accurate than those of `body.moments`.
  SortedTop(const PrincipalMoments3<Scalar>& body, const Vec& momentum) {
    using std::sqrt;
    const auto minus = [&](int a, int b) -> Scalar {  // I_a − I_b
      if (a == b) return 0;
      return b == (a + 1) % 3 ? body.differences((a + 2) % 3)
                              : Scalar(-body.differences((b + 2) % 3));
    };
    for (const auto& [first, second] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 1)})
      if (minus(axis[first], axis[second]) > 0) {
        std::swap(axis[first], axis[second]);
        even = !even;
      }
    I = along(body.moments);
    m = along(momentum);
    const Scalar I_21 = minus(axis[1], axis[0]), I_32 = minus(axis[2], axis[1]), I_31 = I_21 + I_32;
    difference << 0, -I_21, -I_31, I_21, 0, -I_32, I_31, I_32, 0;
    const Vec twice_energies = m.cwiseAbs2().cwiseQuotient(I);
    G = sqrt(m.squaredNorm());
    two_E = twice_energies.sum();
    Delta = difference.transpose() * twice_energies;
    // Δ₂ cancels next to the separatrix. This form has the fewest roundings, and is 0 on the
    // separatrix.
    Delta(1) = (m(2) * m(2) * (I_32 * I(0)) - m(0) * m(0) * (I_21 * I(2))) / (I(0) * I(2));
  }

  Vec along(const Vec& v) const { return {v(axis[0]), v(axis[1]), v(axis[2])}; }

  /// Returns the axis i that m circles, counted from 0; k = 2 − i.
  int circled() const { return Delta(1) < 0 ? 0 : 2; }
  /// Returns 1 − k² of Jacobi's functions; 1 where it is 0/0, for a symmetric body that does not
  /// wobble.
  Scalar complementary_parameter() const {
    const int i = circled(), k = 2 - i;
    const Scalar mc = Delta(1) * difference(k, i) / (Delta(k) * difference(1, i));
    return mc < 1 ? mc : Scalar(1);
  }
};

}  // namespace stiefel
