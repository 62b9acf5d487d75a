#pragma once

#include <cmath>

#include "engine/body/exact/sorted_top.h"

namespace stiefel {

/// The motion on the separatrix, Δ₂ = 0, m₁ and m₃ ≥ 0 and not both 0:
///
///     m = (B₁ sech u, G tanh u, B₃ sech u),   u = λt + u₀,
///     ψ = (2E/G) t + 2 [atan2(B₃ tanh(u/2), G + B₁)] from u₀ to u.
template <class Scalar>
class HyperbolicTop {
 public:
  using Vec = Vector3<Scalar>;

  explicit HyperbolicTop(const SortedTop<Scalar>& top) : G_(top.G) {
    using std::asinh, std::sqrt;
    const Vec &I = top.I, &m = top.m, &Delta = top.Delta;
    two_E_over_G_ = top.two_E / G_;
    lambda_ = sqrt(-Delta(0) * Delta(2) / (I(0) * I(2))) / G_;
    u_0_ = asinh(m(1) / sqrt(m(0) * m(0) + m(2) * m(2)));
    B_1_ = sqrt(I(0) * Delta(2) / top.difference(0, 2));
    B_3_ = sqrt(I(2) * Delta(0) / top.difference(2, 0));
  }

  int axis() const { return 0; }

  Vec m(Scalar t) const {
    using std::cosh, std::tanh;
    const Scalar u = lambda_ * t + u_0_;
    return {B_1_ / cosh(u), G_ * tanh(u), B_3_ / cosh(u)};
  }

  Scalar psi(Scalar t) const {
    return two_E_over_G_ * t + 2 * (angle(lambda_ * t + u_0_) - angle(u_0_));
  }

 private:
  Scalar angle(Scalar u) const {
    using std::atan2, std::tanh;
    return atan2(B_3_ * tanh(u / 2), G_ + B_1_);
  }

  Scalar G_, two_E_over_G_, lambda_, u_0_, B_1_, B_3_;
};

}  // namespace stiefel
