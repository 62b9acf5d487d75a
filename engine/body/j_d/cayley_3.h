#pragma once

#include "engine/dense/so_3.h"
#include "engine/numbers/pack.h"

namespace stiefel {

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

}  // namespace stiefel
