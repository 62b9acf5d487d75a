#pragma once

#include "engine/dense/so_4.h"
#include "engine/numbers/pack.h"

namespace stiefel {

/// The equation of the discrete rigid body in four dimensions, for the skew C of U = (I − C)⁻¹(I +
/// C), U = J_D⁻¹(hM). C⁴ + σC² + p² = 0 with σ = |a|² + |b|², p = Pf(C), therefore
///
///     C(I − C²)⁻¹ = (C + p C̃)/τ,   C²(I − C²)⁻¹ = (C² − p²)/τ,   τ = 1 + σ + p²,
///
/// and with n = (h/2) M_ij/(λ_i + λ_j) and κ = (λ_i − λ_j)/(λ_i + λ_j), element by element,
///
///     G(C) = C + p C̃ − κ∘C² − τ n = 0.
///
/// The class finds the solution that goes to 0 with n, for h‖Ω‖ well below 1.
template <class Scalar>
class CayleyEquation4 {
 public:
  using Vec = Skew4<Scalar>;

  Vec c = Vec::Zero();

  /// Makes two sweeps of the fixed point, then uses Newton's method with G′⁻¹ = (I − E)⁻¹ ≈ I + E +
  /// E². Returns the lanes that have a solution.
  Mask<Scalar> solve(const Vec& n, const Vec& kappa) {
    c = n;
    c -= called_residual(n, kappa);
    c -= called_residual(n, kappa);
    const Scalar small = two_to<Scalar>(-2 * bits<Scalar>) * dot(c, c);
    Scalar last = dot(c, c);
    Mask<Scalar> found{};
    constexpr int most = 12;
    for (int k = 0; k < most; ++k) {
      const Vec delta = correction(called_residual(n, kappa), n, kappa);
      const Scalar change = dot(delta, delta);
      for (int i = 0; i < 6; ++i) c(i) = select(found, c(i), c(i) - delta(i));
      // The next change is smaller by the factor change / last; the first ratio is not reliable.
      if (k > 0) found = found | (change * change <= small * last);
      if (all(found)) break;
      last = change;
    }
    return found;
  }

  Scalar pfaffian() const { return (c(0) * c(3) + c(1) * c(4)) + c(2) * c(5); }

  Vec residual(const Vec& n, const Vec& kappa) const {
    const Scalar p = pfaffian(), tau = Scalar(1) + (dot(c, c) + p * p);
    const Vec dual_c = dual(c), square_c = square(c);
    Vec G;
    for (int i = 0; i < 6; ++i)
      G(i) = (c(i) + p * dual_c(i)) - (kappa(i) * square_c(i) + tau * n(i));
    return G;
  }

  /// Returns G′⁻¹ G, up to terms in E³.
  Vec correction(const Vec& G, const Vec& n, const Vec& kappa) const {
    const Vec once = G + error(G, n, kappa);
    return G + error(once, n, kappa);
  }

 private:
  /// Returns the residual. For numbers it is a call: three copies in one function are too many for
  /// the registers, which made a step a twentieth longer.
  Vec called_residual(const Vec& n, const Vec& kappa) const {
    if constexpr (std::is_arithmetic_v<Scalar>)
      return residual_apart(n, kappa);
    else
      return residual(n, kappa);
  }
  [[gnu::noinline]] Vec residual_apart(const Vec& n, const Vec& kappa) const {
    return residual(n, kappa);
  }
  /// Returns Eδ = δ − G′δ.
  Vec error(const Vec& delta, const Vec& n, const Vec& kappa) const {
    const Scalar p = pfaffian(), dp = dot(dual(c), delta);
    const Scalar dtau = 2 * (dot(c, delta) + p * dp);
    const Vec dual_c = dual(c), dual_delta = dual(delta), both = anticommutator(c, delta);
    Vec out;
    for (int i = 0; i < 6; ++i)
      out(i) = (kappa(i) * both(i) + dtau * n(i)) - (dp * dual_c(i) + p * dual_delta(i));
    return out;
  }
};

}  // namespace stiefel
