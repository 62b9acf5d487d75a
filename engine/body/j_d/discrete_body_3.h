#pragma once

#include <cmath>

#include "engine/body/j_d/discrete_inertia.h"
#include "engine/dense/principal_moments_3.h"
#include "engine/dense/so_3.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/double_word.h"
#include "engine/numbers/pack.h"

namespace stiefel {

/// Returns the product (q + ε)∘(w, v) with an error of about 2^(−3/2 bits). |q|, |(w, v)| ≤ 1, ε is
/// the rounding error of q, and w and v are double words. The high halves q₁ of q and p₁ of p = (w,
/// v) are multiples of 2^−r with 2r < bits, so the sums of q₁∘p₁ are exact, and the rest, (q − q₁ +
/// ε)∘p₁ + q∘(p − p₁), is small.
template <class X, class Wide>
Eigen::Matrix<Wide, 4, 1> quaternion_product(const X& q, const X& epsilon, const Wide& w,
                                             const Vector3<Wide>& v) {
  using T = typename X::Scalar;
  if constexpr (std::is_same_v<T, Wide>) {
    return So3<T, true>::quaternion_times(q + epsilon, w, v);
  } else {
    using Space = So3<T, true>;
    using Quaternion = Eigen::Matrix<T, 4, 1>;
    constexpr int r = (bits<T> - 1) / 2;
    const T shift = T(3) * two_to<T>(bits<T> - 2 - r);
    const auto rounded = [&](const T& x) { return (x + shift) - shift; };
    Quaternion q1, q2;
    for (int i = 0; i < 4; ++i) {
      q1(i) = rounded(q(i));
      q2(i) = (q(i) - q1(i)) + epsilon(i);
    }
    const T w1 = rounded(w.high), w2 = (w.high - w1) + w.low;
    Vector3<T> v1, v2;
    for (int i = 0; i < 3; ++i) {
      v1(i) = rounded(v(i).high);
      v2(i) = (v(i).high - v1(i)) + v(i).low;
    }
    const Quaternion high = Space::quaternion_times(q1, w1, v1);
    const Quaternion low = Space::quaternion_times(q2, w1, v1) + Space::quaternion_times(q, w2, v2);
    Eigen::Matrix<Wide, 4, 1> product;
    for (int i = 0; i < 4; ++i) product(i) = Wide(high(i), low(i));
    return product;
  }
}

/// The inverse of a 3 × 3 matrix by its cofactors, with one division and no branch.
template <class Scalar>
class Inverse3 {
 public:
  Inverse3() = default;
  /// Takes the matrix by its rows a, b, c.
  Inverse3(const Vector3<Scalar>& a, const Vector3<Scalar>& b, const Vector3<Scalar>& c)
      : bc_(b.cross(c)), ca_(c.cross(a)), ab_(a.cross(b)), reciprocal_(1 / dot(a, bc_)) {}

  Vector3<Scalar> operator*(const Vector3<Scalar>& v) const {
    return reciprocal_ * (v(0) * bc_ + v(1) * ca_ + v(2) * ab_);
  }

 private:
  Vector3<Scalar> bc_, ca_, ab_;
  Scalar reciprocal_;
};

/// The discrete rigid body's equation in three dimensions,
///
///     c = (1 + |c|²) n + κ∘(c₂c₃, c₃c₁, c₁c₂)
///
/// for the vector c of U = (I − ĉ)⁻¹(I + ĉ): U = J_D⁻¹(hM) with n = (h/2) m/I and κ₁ = (I₂ −
/// I₃)/I₁, cyclic (Hairer and Vilmart 2006). The class finds the solution that goes to 0 with n.
template <class Scalar>
class CayleyEquation3 {
 public:
  using Vec = Vector3<Scalar>;

  Vec c = Vec::Zero();

  /// Solves by the chord method and, where it fails, by Newton's method. Returns false if neither
  /// finds a solution.
  bool solve(const Vec& n, const Vec& kappa) {
    if (chord(n, kappa)) return true;
    c = n;
    return newton(n, kappa);
  }

  /// Makes two sweeps of the fixed point, then uses the chord method: the equation is quadratic, so
  /// c − Δ solves it when Δ = G′⁻¹(G − |Δ|² n − κ∘(Δ₂Δ₃, …)), with G and G′ at c. Each round gains
  /// as many digits as the two sweeps found. Returns the lanes that have a solution.
  Mask<Scalar> chord(const Vec& n, const Vec& kappa) {
    c = n;
    c = image(n, kappa);
    c = image(n, kappa);
    const Vec G = c - image(n, kappa);
    differentiate(n, kappa);
    const Vec newton_step = inverse_ * G;
    const Scalar small = two_to<Scalar>(-2 * bits<Scalar>) * squared_norm(c);
    Vec delta = newton_step;
    Scalar first = 1;  // square of the first change of Δ
    Mask<Scalar> found{};
    constexpr int most = 5;
    for (int k = 0; k < most; ++k) {
      const Vec next = newton_step + inverse_ * curvature(n, kappa, delta);
      const Scalar change = squared_norm<Scalar>(next - delta);
      delta = select(found, delta, next);
      if (k == 0) first = change;
      // The next change is smaller than this one by the factor |first change| / |Δ|.
      found = found | (change * first <= small * squared_norm(delta));
      if (all(found)) break;
    }
    c -= delta;
    return found;
  }

  /// Iterates Newton's method from the current c. Returns false if it does not converge.
  bool newton(const Vec& n, const Vec& kappa) {
    // After a correction of relative size ε the error is about ε².
    const Scalar enough = two_to<Scalar>(-(bits<Scalar> + 1) / 2);
    constexpr int most = 20;
    using std::isfinite;
    for (int k = 0; k < most; ++k) {
      differentiate(n, kappa);
      const Vec delta = inverse_ * Vec(c - image(n, kappa));
      c -= delta;
      const Scalar size = delta.cwiseAbs().maxCoeff();
      if (!isfinite(size)) return false;
      if (size <= enough * c.cwiseAbs().maxCoeff()) return true;
    }
    return false;
  }

  /// Returns G′⁻¹ r with the last G′ computed.
  Vec correction(const Vec& r) const { return inverse_ * r; }

 private:
  /// Returns the right-hand side of the equation.
  [[gnu::always_inline]] Vec image(const Vec& n, const Vec& kappa) const {
    return n + squared_norm(c) * n + kappa.cwiseProduct(cyclic_product<Scalar>(c, c));
  }
  static Vec curvature(const Vec& n, const Vec& kappa, const Vec& delta) {
    return -squared_norm(delta) * n - kappa.cwiseProduct(cyclic_product<Scalar>(delta, delta));
  }
  [[gnu::always_inline]] void differentiate(const Vec& n, const Vec& kappa) {
    const Vec d = 2 * c, k = kappa;
    inverse_ =
        Inverse3<Scalar>({1 - n(0) * d(0), -n(0) * d(1) - k(0) * c(2), -n(0) * d(2) - k(0) * c(1)},
                         {-n(1) * d(0) - k(1) * c(2), 1 - n(1) * d(1), -n(1) * d(2) - k(1) * c(0)},
                         {-n(2) * d(0) - k(2) * c(1), -n(2) * d(1) - k(2) * c(0), 1 - n(2) * d(2)});
  }

  Inverse3<Scalar> inverse_;
};

/// One step of the discrete rigid body of Moser and Veselov in three dimensions, on (q; m) or m
/// alone: U = J_D⁻¹(hM) as the Cayley transform U = (I − ĉ)⁻¹(I + ĉ), then Q ← QU and M ← UᵀMU,
///
///     q ← q∘(1, c)/|(1, c)|,   m₁ ← m₁ + (4/h)(I₂ − I₃) c₂c₃/(1 + |c|²) and cyclic.
///
/// No λ_i is a divisor, so a thin plate needs no special case. For any constant positive moments
/// the step keeps |m|², Σ m_i²/I_i and Q m.
///
/// With `frame` a state holds q; `moves_frame` says whether the scene has a Q that moves.
template <class Scalar, bool frame>
class DiscreteBody3 {
 public:
  explicit DiscreteBody3(bool moves_frame = true) : moves_frame_(frame && moves_frame) {}

  using Point = typename So3<Scalar, frame>::State;
  using State = Accumulator<Point>;
  using Wide = Doubled<Scalar>;
  using Inertia = DiscreteInertia3<Scalar>;

  /// Finds c. Returns false where no c exists on the branch of the identity.
  bool solve(const State& x, const Inertia& I) {
    return I.positive && equation_.solve(n(x, I), I.kappa) && on_branch(I);
  }
  /// Finds c in the lanes where the chord method succeeds, and returns those lanes.
  Mask<Scalar> solve_where_easy(const State& x, const Inertia& I) {
    const Mask<Scalar> found = equation_.chord(n(x, I), I.kappa);
    return I.positive & found & (squared_norm(equation_.c) < I.near);
  }
  /// Finds c for the step t·h, starting from the solution found last.
  bool continue_to(const State& x, const Inertia& I, Scalar t = 1) {
    const Vector3<Scalar> found = equation_.c;
    if (I.positive && equation_.newton(t * n(x, I), I.kappa) && on_branch(I)) return true;
    equation_.c = found;
    return false;
  }
  void restart() { equation_.c.setZero(); }

  /// Applies the step with the c found last.
  void transport(State& x, const Inertia& I) const {
    x.compensated ? transport_compensated(x, I) : transport_plain(x.value, I);
  }

 private:
  static constexpr int first = frame ? 4 : 0;  // where m starts

  static Vector3<Scalar> m(const State& x) { return x.value.template tail<3>(); }
  static Vector3<Scalar> n(const State& x, const Inertia& I) {
    return I.half_step_over_I.cwiseProduct(m(x));
  }

  /// Whether all w_i + w_j, w = spec(UΛ), have positive real parts, which holds on the branch that
  /// starts at the identity. The characteristic polynomial of UΛ depends only on the diagonal of U:
  ///
  ///     e₁ = Σ λ_iU_ii,   e₂ = λ₂λ₃U₁₁ + …,   e₃ = λ₁λ₂λ₃.
  ///
  /// The polynomial whose roots are the sums has the coefficients 2e₁, e₁² + e₂ and e₁e₂ − e₃. The
  /// test is that of Routh and Hurwitz.
  [[gnu::always_inline]] bool on_branch(const Inertia& I) const {
    return squared_norm(equation_.c) < I.near || has_positive_spectrum(I);
  }
  bool has_positive_spectrum(const Inertia& I) const {
    const Vector3<Scalar> lambda = I.lambda / I.lambda.maxCoeff();  // scaled to keep cubes in range
    const Vector3<Scalar> c2 = equation_.c.cwiseAbs2();
    const Scalar all = 1 + c2.sum();
    const Vector3<Scalar> U = (2 * (1 + c2.array()) / all - 1).matrix();
    const Scalar e1 = lambda.dot(U), e2 = cyclic_product<Scalar>(lambda, lambda).dot(U);
    const Scalar sums = 2 * e1, minors = e1 * e1 + e2, product = e1 * e2 - lambda.prod();
    return sums > 0 && product > 0 && sums * minors > product;
  }

  void transport_plain(Point& x, const Inertia& I) const {
    using std::sqrt;
    const Vector3<Scalar>& c = equation_.c;
    const Scalar w = 1 / (1 + squared_norm(c));
    x.template tail<3>() += w * I.gain.cwiseProduct(cyclic_product<Scalar>(c, c));
    if constexpr (frame) {
      if (!moves_frame_) return;
      const Eigen::Matrix<Scalar, 4, 1> q = So3<Scalar, true>::quaternion_times(x, Scalar(1), c);
      const Scalar q2 = (q(0) * q(0) + q(1) * q(1)) + (q(2) * q(2) + q(3) * q(3));
      // Makes one Newton step for |q|^−1 from √w, which differs from it only by rounding.
      x.template head<4>() = (sqrt(w) * (3 - w * q2) / 2) * q;
    }
  }

  void transport_compensated(State& x, const Inertia& I) const {
    using std::sqrt;
    const Solution at = solution(x, I);
    const Scalar one(1), two(2);
    const Wide w = Wide(one) / (one + at.c2), w2 = two * w;
    if constexpr (frame)
      if (moves_frame_) {
        const Wide s = sqrt(w);
        const auto dq = quaternion_product(x.value, x.carry, -(at.c2 * w / (one + s)),
                                           Vector3<Wide>(s * at.c(0), s * at.c(1), s * at.c(2)));
        for (int i = 0; i < 4; ++i) x.add(i, dq(i));
      }
    for (int i = 0; i < 3; ++i) x.add(first + i, w2 * at.twist(i));
  }

  /// c after a last correction, the products (I₂ − I₃)/(h/2) c₂c₃ and cyclic (`twist`), and |c|².
  struct Solution {
    Vector3<Wide> c, twist;
    Wide c2;
  };

  /// Corrects c once. Computes the residual in double words,
  ///
  ///     F = I/(h/2)∘c − (I₂ − I₃)/(h/2) c₂c₃ … − (1 + |c|²) m,
  ///
  /// and changes the quantities that depend on c to first order; higher orders are below rounding.
  Solution solution(const State& x, const Inertia& I) const {
    const Vector3<Scalar>& c = equation_.c;
    const Scalar one(1);
    Solution at;
    at.c2 = wide_product(c(0), c(0)) + wide_product(c(1), c(1)) + wide_product(c(2), c(2));
    const Wide scale = one + at.c2;
    Vector3<Scalar> G;
    for (int i = 0; i < 3; ++i) {
      at.twist(i) = I.differences_h(i) * wide_product(c((i + 1) % 3), c((i + 2) % 3));
      const Wide F = c(i) * I.moments_h(i) - at.twist(i) - scale * x.doubled(first + i);
      G(i) = static_cast<Scalar>(F) * I.half_step_over_I(i);
    }
    const Vector3<Scalar> change = -equation_.correction(G);
    at.c2 = at.c2 + Wide(2 * dot(c, change));
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      at.c(i) = c(i) + Wide(change(i));
      at.twist(i) = at.twist(i) + Wide(static_cast<Scalar>(I.differences_h(i)) *
                                       (c(j) * change(k) + c(k) * change(j)));
    }
    return at;
  }

  bool moves_frame_;
  CayleyEquation3<Scalar> equation_;
};

}  // namespace stiefel
