#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// so(4) in coordinates: x = (a, b) is the matrix X = [[hat(a), b], [−bᵀ, 0]], and x_k is its
/// element (rows[k], columns[k]). Not aligned, because Eigen's alignment depends on the instruction
/// set and the layout must not.
template <class Scalar>
using Skew4 = Eigen::Matrix<Scalar, 6, 1, Eigen::DontAlign>;
inline constexpr int skew4_rows[] = {2, 0, 1, 0, 1, 2};
inline constexpr int skew4_columns[] = {1, 2, 0, 3, 3, 3};

// Sums with a fixed order of additions, the same for numbers and for packs.

template <class Scalar>
Scalar dot(const Skew4<Scalar>& x, const Skew4<Scalar>& y) {
  return ((x(0) * y(0) + x(1) * y(1)) + x(2) * y(2)) + ((x(3) * y(3) + x(4) * y(4)) + x(5) * y(5));
}

/// Returns the dual (b, a): X X̃ = −Pf(X) I, Pf(X) = a·b.
template <class Scalar>
Skew4<Scalar> dual(const Skew4<Scalar>& x) {
  Skew4<Scalar> y;
  y << x(3), x(4), x(5), x(0), x(1), x(2);
  return y;
}

/// Returns the elements of X² at the positions of a and b: a₂a₃ − b₂b₃ and cyclic, and a × b.
/// `times` multiplies two numbers.
template <class Scalar, class Times>
auto square(const Skew4<Scalar>& x, Times times) {
  Skew4<decltype(times(x(0), x(0)))> y;
  y << times(x(1), x(2)) - times(x(4), x(5)), times(x(2), x(0)) - times(x(5), x(3)),
      times(x(0), x(1)) - times(x(3), x(4)), times(x(1), x(5)) - times(x(2), x(4)),
      times(x(2), x(3)) - times(x(0), x(5)), times(x(0), x(4)) - times(x(1), x(3));
  return y;
}
template <class Scalar>
Skew4<Scalar> square(const Skew4<Scalar>& x) {
  return square(x, [](const Scalar& a, const Scalar& b) { return a * b; });
}
/// Returns the elements of XY + YX at the positions of a and b.
template <class Scalar>
Skew4<Scalar> anticommutator(const Skew4<Scalar>& x, const Skew4<Scalar>& y) {
  const auto s = [&](int i, int j) { return x(i) * y(j) + x(j) * y(i); };
  Skew4<Scalar> z;
  z << s(1, 2) - s(4, 5), s(2, 0) - s(5, 3), s(0, 1) - s(3, 4), s(1, 5) - s(2, 4),
      s(2, 3) - s(0, 5), s(0, 4) - s(1, 3);
  return z;
}

/// λ_i + λ_j and λ_i − λ_j at the positions of a and b.
template <class Scalar>
struct PairSums4 {
  Skew4<Scalar> moments, differences;

  template <class Derived>
  explicit PairSums4(const Eigen::MatrixBase<Derived>& lambda)
      : lambda_(lambda.template cast<Scalar>()) {
    for (int k = 0; k < 6; ++k) {
      const Scalar &l = lambda_(skew4_rows[k]), &r = lambda_(skew4_columns[k]);
      moments(k) = l + r;
      differences(k) = l - r;
    }
  }

  const Eigen::Matrix<Scalar, 4, 1>& lambda() const { return lambda_; }

  /// Returns a bound of |C|² below which a solution C is certainly on the branch of the identity: 1
  /// if no λ_i < 0, as in three dimensions, else 0 (no bound is known).
  Scalar nearness() const { return lambda_.minCoeff() >= Scalar(0) ? Scalar(1) : Scalar(0); }

 private:
  Eigen::Matrix<Scalar, 4, 1> lambda_;
};

/// The pair (Q, M) in four dimensions, in coordinates: Q column after column, then m = (a, b) of M,
/// 22 numbers; or m alone, 6 numbers. SoN is the general case. So4 has the functions that explicit
/// methods and the discrete body need, with every operation written out, for numbers and packs.
template <class Scalar_, bool frame>
struct So4 {
  using Scalar = Scalar_;
  static constexpr bool has_frame = frame;
  static constexpr int first = frame ? 16 : 0;  ///< where m starts
  using State = Eigen::Matrix<Scalar, first + 6, 1>;
  using Algebra = Skew4<Scalar>;
  using Lambda = Eigen::Matrix<Scalar, 4, 1>;

  explicit So4(Eigen::Index = 4) {}

  static Algebra zero() { return Algebra::Zero(); }
  static Algebra m(const State& x) { return x.template tail<6>(); }

  /// Computes J⁻¹: Ω_ij = M_ij / (λ_i + λ_j), with the reciprocals stored.
  class InverseInertia {
   public:
    explicit InverseInertia(const Lambda& lambda) {
      const PairSums4<Scalar> pairs(lambda);
      for (int k = 0; k < 6; ++k) inverse_(k) = 1 / pairs.moments(k);
    }
    void operator()(const State& x, Algebra& Omega) const {
      for (int k = 0; k < 6; ++k) Omega(k) = inverse_(k) * x(first + k);
    }

   private:
    Algebra inverse_;
  };

  /// Computes (QΩ, [M, Ω]) for M = J(Ω): [M, Ω]_ij = (λ_i − λ_j)(Ω²)_ij.
  static void velocity(const Lambda& lambda, const State& x, const Algebra& Omega, State& dx) {
    if constexpr (frame) {
      const Algebra& w = Omega;
      for (int r = 0; r < 4; ++r) {
        const Scalar &q0 = x(r), &q1 = x(4 + r), &q2 = x(8 + r), &q3 = x(12 + r);
        dx(r) = (w(2) * q1 - w(1) * q2) - w(3) * q3;
        dx(4 + r) = (w(0) * q2 - w(2) * q0) - w(4) * q3;
        dx(8 + r) = (w(1) * q0 - w(0) * q1) - w(5) * q3;
        dx(12 + r) = (w(3) * q0 + w(4) * q1) + w(5) * q2;
      }
    }
    const Algebra Omega2 = square(Omega);
    for (int k = 0; k < 6; ++k)
      dx(first + k) = (lambda(skew4_rows[k]) - lambda(skew4_columns[k])) * Omega2(k);
  }
};

}  // namespace stiefel
