#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "engine/numbers/scalar.h"

namespace stiefel {

// Sums with a fixed order of additions, the same for numbers and for packs.

template <class Scalar>
Scalar dot(const Vector3<Scalar>& a, const Vector3<Scalar>& b) {
  return (a(0) * b(0) + a(1) * b(1)) + a(2) * b(2);
}
template <class Scalar>
Scalar squared_norm(const Vector3<Scalar>& a) {
  return dot(a, a);
}

/// Returns (a₂b₃, a₃b₁, a₁b₂).
template <class Scalar>
Vector3<Scalar> cyclic_product(const Vector3<Scalar>& a, const Vector3<Scalar>& b) {
  return {a(1) * b(2), a(2) * b(0), a(0) * b(1)};
}

/// The pair (Q, M) in three dimensions, in coordinates: Q as Hamilton's quaternion (w, x, y, z)
/// with Q v = q v q*, and M = hat(m), hat(u) v = u × v. A state is (q; m), 7 numbers, or m alone, 3
/// numbers. An element of the algebra so(3) is a vector of R³. SoN has the same functions for every
/// N.
template <class Scalar_, bool frame>
struct So3 {
  using Scalar = Scalar_;
  static constexpr bool has_frame = frame;
  using State = Eigen::Matrix<Scalar, frame ? 7 : 3, 1>;
  using Algebra = Vector3<Scalar>;
  using Lambda = Vector3<Scalar>;

  explicit So3(Eigen::Index = 3) {}

  static Algebra zero() { return Algebra::Zero(); }
  static auto m(const State& x) { return x.template tail<3>(); }

  /// Computes J⁻¹: Ω_ij = M_ij / (λ_i + λ_j), that is ω_k = m_k / I_k, I_1 = λ_2 + λ_3 and cyclic.
  static void inverse_inertia(const Lambda& lambda, const State& x, Algebra& omega) {
    omega << x(x.size() - 3) / (lambda(1) + lambda(2)), x(x.size() - 2) / (lambda(2) + lambda(0)),
        x(x.size() - 1) / (lambda(0) + lambda(1));
  }

  /// Computes J⁻¹ with the reciprocals 1/I stored.
  class InverseInertia {
   public:
    explicit InverseInertia(const Lambda& l) {
      inverse_ << 1 / (l(1) + l(2)), 1 / (l(2) + l(0)), 1 / (l(0) + l(1));
    }
    void operator()(const State& x, Algebra& omega) const { omega = inverse_.cwiseProduct(m(x)); }

   private:
    Vector3<Scalar> inverse_;
  };

  /// Computes (QΩ, [M, Ω]) for M = J(Ω): q̇ = ½ q∘(0, ω), ṁ = m × ω, whose first component is (I₂ −
  /// I₃)ω₂ω₃ with I₂ − I₃ = λ₃ − λ₂, and cyclic.
  static void velocity(const Lambda& lambda, const State& x, const Algebra& omega, State& dx) {
    if constexpr (frame) dx.template head<4>() = quaternion_times(x, Algebra(omega * Scalar(0.5)));
    dx.template tail<3>() << (lambda(2) - lambda(1)) * (omega(1) * omega(2)),
        (lambda(0) - lambda(2)) * (omega(2) * omega(0)),
        (lambda(1) - lambda(0)) * (omega(0) * omega(1));
  }

  /// Computes [a, b] = ab − ba in so(3): a × b.
  static void bracket(const Algebra& a, const Algebra& b, Algebra& c) { c = a.cross(b); }

  /// Computes (Q exp Θ − Q, exp(Θ)ᵀ M exp(Θ) − M), without cancellation for small Θ.
  static void displacement(const State& x, const Algebra& theta, State& dx) {
    const Scalar angle = theta.norm();
    const Scalar s = sinc(angle / 2), c = sinc(angle / 4);
    // exp(Θ/2) as a quaternion, minus 1: (cos(θ/2) − 1, sin(θ/2)/θ Θ)
    if constexpr (frame)
      dx.template head<4>() = quaternion_times(x, -angle * angle * c * c / 8, theta * (s / 2));
    // exp(−Θ) m − m = −(sin θ/θ) Θ × m + ((1 − cos θ)/θ²) Θ × (Θ × m)
    const Algebra turn = theta.cross(m(x));
    dx.template tail<3>() = theta.cross(turn) * (s * s / 2) - turn * sinc(angle);
  }

  /// Returns q∘(w, v); q is the first four elements of x.
  template <class X, class V>
  static Eigen::Matrix<Scalar, 4, 1> quaternion_times(const X& x, Scalar w, const V& v) {
    Eigen::Matrix<Scalar, 4, 1> product;
    product << x(0) * w - (x(1) * v(0) + x(2) * v(1) + x(3) * v(2)),
        x(0) * v(0) + x(1) * w + (x(2) * v(2) - x(3) * v(1)),
        x(0) * v(1) + x(2) * w + (x(3) * v(0) - x(1) * v(2)),
        x(0) * v(2) + x(3) * w + (x(1) * v(1) - x(2) * v(0));
    return product;
  }

  /// Returns q∘(0, v); q is the first four elements of x.
  template <class X>
  static Eigen::Matrix<Scalar, 4, 1> quaternion_times(const X& x, const Algebra& v) {
    Eigen::Matrix<Scalar, 4, 1> product;
    product << -(x(1) * v(0) + x(2) * v(1) + x(3) * v(2)),
        x(0) * v(0) + (x(2) * v(2) - x(3) * v(1)), x(0) * v(1) + (x(3) * v(0) - x(1) * v(2)),
        x(0) * v(2) + (x(1) * v(1) - x(2) * v(0));
    return product;
  }

  static Scalar sinc(Scalar a) {
    using std::sin;
    return a == Scalar(0) ? Scalar(1) : sin(a) / a;
  }
};

/// Returns the matrix Q of a quaternion q, without normalisation: QᵀQ = |q|⁴ I, so a drift of |q|
/// shows in Q.
template <class Scalar>
Eigen::Matrix<Scalar, 3, 3> rotation_matrix(const Eigen::Matrix<Scalar, 4, 1>& q) {
  const Scalar w = q(0), x = q(1), y = q(2), z = q(3);
  Eigen::Matrix<Scalar, 3, 3> Q;
  Q << w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z;
  return Q;
}

/// Returns the unit quaternion of a rotation matrix, with w ≥ 0; divides by the largest component,
/// as Shepperd does.
template <class Derived>
Eigen::Matrix<typename Derived::Scalar, 4, 1> quaternion_of(const Eigen::MatrixBase<Derived>& Q) {
  using Scalar = typename Derived::Scalar;
  using std::sqrt;
  const Scalar t[4] = {Q(0, 0) + Q(1, 1) + Q(2, 2), Q(0, 0) - Q(1, 1) - Q(2, 2),
                       Q(1, 1) - Q(2, 2) - Q(0, 0), Q(2, 2) - Q(0, 0) - Q(1, 1)};
  int largest = 0;
  for (int k = 1; k < 4; ++k)
    if (t[k] > t[largest]) largest = k;
  Eigen::Matrix<Scalar, 4, 1> q;
  if (largest == 0) {
    q << 1 + t[0], Q(2, 1) - Q(1, 2), Q(0, 2) - Q(2, 0), Q(1, 0) - Q(0, 1);
  } else {
    const int i = largest - 1, j = (i + 1) % 3, k = (i + 2) % 3;
    q(0) = Q(k, j) - Q(j, k);
    q(1 + i) = 1 + t[largest];
    q(1 + j) = Q(i, j) + Q(j, i);
    q(1 + k) = Q(i, k) + Q(k, i);
  }
  q.normalize();
  return q(0) < 0 ? Eigen::Matrix<Scalar, 4, 1>(-q) : q;
}

/// `hat` maps R³ to so(3), hat(u) v = u × v; `vee` is its inverse.
template <class Derived>
Eigen::Matrix<typename Derived::Scalar, 3, 3> hat(const Eigen::MatrixBase<Derived>& u) {
  Eigen::Matrix<typename Derived::Scalar, 3, 3> U;
  U << 0, -u(2), u(1), u(2), 0, -u(0), -u(1), u(0), 0;
  return U;
}
template <class Derived>
Vector3<typename Derived::Scalar> vee(const Eigen::MatrixBase<Derived>& U) {
  return {U(2, 1), U(0, 2), U(1, 0)};
}

}  // namespace stiefel
