#pragma once

#include <cmath>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// A free rigid body at time 0 along its principal axes, I₁ ≤ I₂ ≤ I₃, with the constants of its
/// motion: G = |m|, 2E = Σ m_i²/I_i and Δ_j = G² − 2E I_j, in a form in which only Δ₂ can cancel.
template <class Scalar>
struct SortedTop {
  using Vec = Vector3<Scalar>;
  Vec I, m, Delta;
  Eigen::Matrix<Scalar, 3, 3> difference;  ///< I_j − I_k
  Scalar G, two_E;

  /// Takes I_21 = I₂ − I₁ and I_32 = I₃ − I₂ separately, because they may be more accurate than the
  /// differences of `moments`.
  SortedTop(const Vec& moments, Scalar I_21, Scalar I_32, const Vec& momentum)
      : I(moments), m(momentum) {
    using std::sqrt;
    const Scalar I_31 = I_21 + I_32;
    difference << 0, -I_21, -I_31, I_21, 0, -I_32, I_31, I_32, 0;
    const Vec twice_energies = m.cwiseAbs2().cwiseQuotient(I);
    G = sqrt(m.squaredNorm());
    two_E = twice_energies.sum();
    Delta = difference.transpose() * twice_energies;
    // Δ₂ cancels next to the separatrix. This form has the fewest roundings, and is 0 on the
    // separatrix.
    Delta(1) = (m(2) * m(2) * (I_32 * I(0)) - m(0) * m(0) * (I_21 * I(2))) / (I(0) * I(2));
  }
};

}  // namespace stiefel
