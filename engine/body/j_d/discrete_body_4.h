#pragma once

#include "engine/body/j_d/discrete_inertia.h"
#include "engine/dense/so_4.h"
#include "engine/numbers/compensated.h"
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

/// One step of the discrete rigid body of Moser and Veselov in four dimensions, on (Q; m) or m
/// alone: U = J_D⁻¹(hM) as the Cayley transform of C (CayleyEquation4), then Q ← QU and M ← UᵀMU,
///
///     Q ← Q + 2Q(C + p C̃ + C² − p²)/τ,   M_ij ← M_ij + (4/h)(λ_i − λ_j)(C²)_ij/τ.
///
/// With `frame` a state holds Q; `moves_frame` says whether the scene has one that moves.
template <class Scalar, bool frame>
class DiscreteBody4 {
 public:
  explicit DiscreteBody4(bool moves_frame = true) : moves_frame_(frame && moves_frame) {}

  using Point = typename So4<Scalar, frame>::State;
  using State = Accumulator<Point>;
  using Wide = Doubled<Scalar>;
  using Inertia = DiscreteInertia4<Scalar>;

  /// Finds C in the lanes where the iteration succeeds, and returns those lanes.
  Mask<Scalar> solve_where_easy(const State& x, const Inertia& I) {
    Skew4<Scalar> n;
    for (int k = 0; k < 6; ++k) n(k) = I.half_step_over_I(k) * x.value(first + k);
    const Mask<Scalar> found = equation_.solve(n, I.kappa);
    return I.positive & found & (dot(equation_.c, equation_.c) < I.near);
  }

  /// Sets C to a solution found by another method.
  void set(const Skew4<Scalar>& c) { equation_.c = c; }

  /// Applies the step with the C found last.
  void transport(State& x, const Inertia& I) const {
    x.compensated ? transport_compensated(x, I) : transport_plain(x.value, I);
  }

 private:
  static constexpr int first = So4<Scalar, frame>::first;  // where m starts

  void transport_plain(Point& x, const Inertia& I) const {
    const Skew4<Scalar>& c = equation_.c;
    const Scalar p = equation_.pfaffian(), w = 1 / (1 + (dot(c, c) + p * p));
    const Skew4<Scalar> c2 = square(c);
    for (int k = 0; k < 6; ++k) x(first + k) += I.gain(k) * (w * c2(k));
    if constexpr (frame)
      if (moves_frame_) {
        const auto dQ = turned(x, c, c2, p, 2 * w);
        for (int k = 0; k < 16; ++k) x(k) += dQ(k);
      }
  }

  /// Computes the residual in double words. The correction of C changes the quantities that depend
  /// on C to first order; higher orders are below rounding.
  void transport_compensated(State& x, const Inertia& I) const {
    const Skew4<Scalar>& c = equation_.c;
    const Scalar one(1), two(2);
    const auto exactly = [](const Scalar& a, const Scalar& b) { return wide_product(a, b); };
    Skew4<Wide> c2 = square(c, exactly);
    Wide sigma(Scalar(0)), p(Scalar(0));
    for (int k = 0; k < 6; ++k) sigma = sigma + wide_product(c(k), c(k));
    for (int k = 0; k < 3; ++k) p = p + wide_product(c(k), c(k + 3));
    const Wide tau = one + (sigma + p * p);
    const Skew4<Scalar> dual_c = dual(c);
    Skew4<Scalar> G, n;
    for (int k = 0; k < 6; ++k) {
      const Wide F = (I.moments_h(k) * (Wide(c(k)) + dual_c(k) * p)) - I.differences_h(k) * c2(k) -
                     tau * x.doubled(first + k);
      G(k) = static_cast<Scalar>(F) * I.half_step_over_I(k);
      n(k) = I.half_step_over_I(k) * x.value(first + k);
    }
    const Skew4<Scalar> change = -equation_.correction(G, n, I.kappa);
    const Skew4<Scalar> c2_change = anticommutator(c, change);
    p = p + Wide(dot(dual_c, change));
    sigma = sigma + Wide(two * dot(c, change));
    const Wide w2 = Wide(two) / (one + (sigma + p * p));
    for (int k = 0; k < 6; ++k) c2(k) = c2(k) + Wide(c2_change(k));
    if constexpr (frame)
      if (moves_frame_) {
        const Skew4<Scalar> now = c + change, squared = c2.template cast<Scalar>();
        const auto dQ =
            turned(x.value, now, squared, static_cast<Scalar>(p), static_cast<Scalar>(w2));
        for (int k = 0; k < 16; ++k) x.add_scalar_with_carry(k, 0, dQ(k));
      }
    for (int k = 0; k < 6; ++k) x.add(first + k, w2 * (I.differences_h(k) * c2(k)));
  }

  /// Returns `scale` · Q (C + p C̃ + C² − p²).
  static Eigen::Matrix<Scalar, 16, 1> turned(const Point& x, const Skew4<Scalar>& c,
                                             const Skew4<Scalar>& c2, const Scalar& p,
                                             const Scalar& scale) {
    const Skew4<Scalar> skew = c + p * dual(c);
    Eigen::Matrix<Scalar, 4, 4> W;
    Scalar p2 = p * p;
    for (int i = 0; i < 4; ++i) W(i, i) = -p2;
    for (int k = 0; k < 6; ++k) {
      const int i = skew4_rows[k], j = skew4_columns[k];
      const Scalar squared = c(k) * c(k);
      W(i, i) -= squared;
      W(j, j) -= squared;
      W(i, j) = c2(k) + skew(k);
      W(j, i) = c2(k) - skew(k);
    }
    Eigen::Matrix<Scalar, 16, 1> out;
    for (int j = 0; j < 4; ++j)
      for (int r = 0; r < 4; ++r)
        out(4 * j + r) = scale * ((x(r) * W(0, j) + x(4 + r) * W(1, j)) +
                                  (x(8 + r) * W(2, j) + x(12 + r) * W(3, j)));
    return out;
  }

  bool moves_frame_;
  CayleyEquation4<Scalar> equation_;
};

}  // namespace stiefel
