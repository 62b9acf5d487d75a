#pragma once

#include <quadmath.h>

#include <Eigen/Core>
#include <compare>
#include <limits>
#include <type_traits>

#include "engine/numbers/dense_product.h"

namespace stiefel {

/// IEEE quadruple precision, 113 bits: wraps the compiler's own type in a class, so that
/// argument-dependent lookup finds its operators and functions. An operation then has a handful of
/// overloads, where the number type of Boost.Multiprecision has hundreds, which templates compile
/// slowly.
///
/// Converts implicitly from every arithmetic type, and explicitly to one, rounding to nearest. The
/// functions are those of libquadmath.
class Quad {
 public:
  __extension__ using Value = __float128;

  constexpr Quad() = default;
  template <class T>
  requires std::is_arithmetic_v<T>
  constexpr Quad(T x) : x_(x) {}
  constexpr Quad(Value x) : x_(x) {}

  template <class T>
  requires std::is_arithmetic_v<T>
  constexpr explicit operator T() const { return static_cast<T>(x_); }
  constexpr Value value() const { return x_; }

  constexpr Quad& operator+=(Quad b) { return *this = *this + b; }
  constexpr Quad& operator-=(Quad b) { return *this = *this - b; }
  constexpr Quad& operator*=(Quad b) { return *this = *this * b; }
  constexpr Quad& operator/=(Quad b) { return *this = *this / b; }

  friend constexpr Quad operator+(Quad a) { return a; }
  friend constexpr Quad operator-(Quad a) { return Quad(-a.x_); }
  friend constexpr Quad operator+(Quad a, Quad b) { return Quad(a.x_ + b.x_); }
  friend constexpr Quad operator-(Quad a, Quad b) { return Quad(a.x_ - b.x_); }
  friend constexpr Quad operator*(Quad a, Quad b) { return Quad(a.x_ * b.x_); }
  friend constexpr Quad operator/(Quad a, Quad b) { return Quad(a.x_ / b.x_); }

  friend constexpr bool operator==(Quad a, Quad b) { return a.x_ == b.x_; }
  friend constexpr auto operator<=>(Quad a, Quad b) { return a.x_ <=> b.x_; }

  friend Quad abs(Quad x) { return fabsq(x.x_); }
  friend Quad sqrt(Quad x) { return sqrtq(x.x_); }
  friend Quad exp(Quad x) { return expq(x.x_); }
  friend Quad log(Quad x) { return logq(x.x_); }
  friend Quad pow(Quad x, Quad y) { return powq(x.x_, y.x_); }
  friend Quad sin(Quad x) { return sinq(x.x_); }
  friend Quad cos(Quad x) { return cosq(x.x_); }
  friend Quad tan(Quad x) { return tanq(x.x_); }
  friend Quad atan(Quad x) { return atanq(x.x_); }
  friend Quad atan2(Quad y, Quad x) { return atan2q(y.x_, x.x_); }
  friend Quad sinh(Quad x) { return sinhq(x.x_); }
  friend Quad cosh(Quad x) { return coshq(x.x_); }
  friend Quad tanh(Quad x) { return tanhq(x.x_); }
  friend Quad asinh(Quad x) { return asinhq(x.x_); }
  friend Quad floor(Quad x) { return floorq(x.x_); }
  friend Quad copysign(Quad x, Quad y) { return copysignq(x.x_, y.x_); }
  friend Quad ldexp(Quad x, int k) { return ldexpq(x.x_, k); }
  friend Quad frexp(Quad x, int* k) { return frexpq(x.x_, k); }
  friend bool isfinite(Quad x) { return finiteq(x.x_) != 0; }
  friend bool isinf(Quad x) { return isinfq(x.x_) != 0; }
  friend bool isnan(Quad x) { return isnanq(x.x_) != 0; }

 private:
  Value x_ = 0;
};

template <>
inline constexpr bool is_multiplied_once<Quad> = true;

}  // namespace stiefel

template <>
class std::numeric_limits<stiefel::Quad> : public std::numeric_limits<long double> {
  using Quad = stiefel::Quad;

 public:
  static constexpr int digits = 113, digits10 = 33, max_digits10 = 36;
  static constexpr Quad epsilon() { return 0x1p-112; }
  static constexpr Quad min() { return 0x1p-16382L; }
  static constexpr Quad max() { return (2 - epsilon()) * 0x1p16383L; }
  static constexpr Quad lowest() { return -max(); }
  static constexpr Quad infinity() { return std::numeric_limits<double>::infinity(); }
  static constexpr Quad quiet_NaN() { return std::numeric_limits<double>::quiet_NaN(); }
};

template <>
struct Eigen::NumTraits<stiefel::Quad> : Eigen::GenericNumTraits<stiefel::Quad> {};
