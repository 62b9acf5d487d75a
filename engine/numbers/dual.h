#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <type_traits>

namespace stiefel {

/// A number with its derivatives along `lanes` directions: value + Σ_k d[k] ε_k, ε_jε_k = 0.
/// Arithmetic carries the derivatives along exactly (forward differentiation). Comparisons, and
/// conversions to an arithmetic type, see the value alone.
template <class Real_, int lanes_>
class Dual {
 public:
  using Real = Real_;
  static constexpr int lanes = lanes_;

  Real value;
  Real d[lanes];

  Dual() = default;
  template <class T>
  requires std::is_arithmetic_v<T>
  constexpr Dual(T x) : value(static_cast<Real>(x)), d{} {}
  template <class T>
  requires std::is_arithmetic_v<T>
  constexpr explicit operator T() const { return static_cast<T>(value); }

  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend constexpr Dual operator-(const Dual& a) {
    return each(-a.value, [&](int k) { return -a.d[k]; });
  }
  friend constexpr Dual operator+(const Dual& a, const Dual& b) {
    return each(a.value + b.value, [&](int k) { return a.d[k] + b.d[k]; });
  }
  friend constexpr Dual operator-(const Dual& a, const Dual& b) {
    return each(a.value - b.value, [&](int k) { return a.d[k] - b.d[k]; });
  }
  friend constexpr Dual operator*(const Dual& a, const Dual& b) {
    return each(a.value * b.value, [&](int k) { return a.value * b.d[k] + a.d[k] * b.value; });
  }
  friend constexpr Dual operator/(const Dual& a, const Dual& b) {
    const Real quotient = a.value / b.value, inverse = 1 / b.value;
    return each(quotient, [&](int k) { return (a.d[k] - quotient * b.d[k]) * inverse; });
  }
  // With a constant, whose derivatives are 0.
  friend constexpr Dual operator*(const Dual& a, Real b) { return a.chain(a.value * b, b); }
  friend constexpr Dual operator*(Real a, const Dual& b) { return b * a; }

  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }

  friend Dual abs(const Dual& x) { return x.value < 0 ? -x : x; }
  /// At 0 the derivatives are 0: the norms whose roots are taken occur in even functions alone.
  friend Dual sqrt(const Dual& x) {
    const Real root = std::sqrt(x.value);
    return x.chain(root, root > 0 ? 1 / (2 * root) : Real(0));
  }
  friend Dual sin(const Dual& x) { return x.chain(std::sin(x.value), std::cos(x.value)); }
  friend Dual cos(const Dual& x) { return x.chain(std::cos(x.value), -std::sin(x.value)); }
  friend Dual tan(const Dual& x) {
    const Real t = std::tan(x.value);
    return x.chain(t, 1 + t * t);
  }
  friend Dual atan(const Dual& x) {
    return x.chain(std::atan(x.value), 1 / (1 + x.value * x.value));
  }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const Real square = x.value * x.value + y.value * y.value;
    return each(std::atan2(y.value, x.value),
                [&](int k) { return (x.value * y.d[k] - y.value * x.d[k]) / square; });
  }
  friend Dual cosh(const Dual& x) { return x.chain(std::cosh(x.value), std::sinh(x.value)); }
  friend Dual tanh(const Dual& x) {
    const Real t = std::tanh(x.value);
    return x.chain(t, 1 - t * t);
  }
  friend Dual asinh(const Dual& x) {
    return x.chain(std::asinh(x.value), 1 / std::sqrt(1 + x.value * x.value));
  }
  friend Dual floor(const Dual& x) { return Dual(std::floor(x.value)); }
  friend Dual ldexp(const Dual& x, int k) {
    const Real scale = std::ldexp(Real(1), k);
    return x.chain(std::ldexp(x.value, k), scale);
  }

 private:
  template <class Derivative>
  [[gnu::always_inline]] static constexpr Dual each(Real value, const Derivative& derivative) {
    Dual c;
    c.value = value;
    for (int k = 0; k < lanes; ++k) c.d[k] = derivative(k);
    return c;
  }
  /// Returns f(x) from f and f′ at the value.
  [[gnu::always_inline]] constexpr Dual chain(Real f, Real slope) const {
    return each(f, [&](int k) { return slope * d[k]; });
  }
};

/// The values of a matrix of dual numbers, and its derivatives along one direction.
template <class Real, int lanes, int rows, int cols>
auto values_of(const Eigen::Matrix<Dual<Real, lanes>, rows, cols>& X) {
  return Eigen::Matrix<Real, rows, cols>(
      X.unaryExpr([](const Dual<Real, lanes>& x) { return x.value; }));
}
template <class Real, int lanes, int rows, int cols>
auto lane_of(const Eigen::Matrix<Dual<Real, lanes>, rows, cols>& X, int k) {
  return Eigen::Matrix<Real, rows, cols>(
      X.unaryExpr([k](const Dual<Real, lanes>& x) { return x.d[k]; }));
}
}  // namespace stiefel

template <class Real, int lanes>
class std::numeric_limits<stiefel::Dual<Real, lanes>> : public std::numeric_limits<Real> {};

template <class Real, int lanes>
struct Eigen::NumTraits<stiefel::Dual<Real, lanes>>
    : Eigen::GenericNumTraits<stiefel::Dual<Real, lanes>> {};
