#pragma once

#include <quadmath.h>

#include <Eigen/Core>
#include <limits>
#include <type_traits>

#include "engine/numbers/eigen_products.h"

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
  friend constexpr bool operator<(Quad a, Quad b) { return a.x_ < b.x_; }
  friend constexpr bool operator>(Quad a, Quad b) { return a.x_ > b.x_; }
  friend constexpr bool operator<=(Quad a, Quad b) { return a.x_ <= b.x_; }
  friend constexpr bool operator>=(Quad a, Quad b) { return a.x_ >= b.x_; }

  friend Quad abs(Quad x) { return fabsq(x.x_); }
  friend Quad sqrt(Quad x) { return sqrtq(x.x_); }
  friend Quad exp(Quad x) { return expq(x.x_); }
  friend Quad exp2(Quad x) { return exp2q(x.x_); }
  friend Quad log(Quad x) { return logq(x.x_); }
  friend Quad log2(Quad x) { return log2q(x.x_); }
  friend Quad pow(Quad x, Quad y) { return powq(x.x_, y.x_); }
  friend Quad hypot(Quad x, Quad y) { return hypotq(x.x_, y.x_); }
  friend Quad sin(Quad x) { return sinq(x.x_); }
  friend Quad cos(Quad x) { return cosq(x.x_); }
  friend Quad tan(Quad x) { return tanq(x.x_); }
  friend Quad asin(Quad x) { return asinq(x.x_); }
  friend Quad acos(Quad x) { return acosq(x.x_); }
  friend Quad atan(Quad x) { return atanq(x.x_); }
  friend Quad atan2(Quad y, Quad x) { return atan2q(y.x_, x.x_); }
  friend Quad sinh(Quad x) { return sinhq(x.x_); }
  friend Quad cosh(Quad x) { return coshq(x.x_); }
  friend Quad tanh(Quad x) { return tanhq(x.x_); }
  friend Quad asinh(Quad x) { return asinhq(x.x_); }
  friend Quad floor(Quad x) { return floorq(x.x_); }
  friend Quad ceil(Quad x) { return ceilq(x.x_); }
  friend Quad copysign(Quad x, Quad y) { return copysignq(x.x_, y.x_); }
  friend Quad ldexp(Quad x, int k) { return ldexpq(x.x_, k); }
  friend Quad frexp(Quad x, int* k) { return frexpq(x.x_, k); }
  friend int ilogb(Quad x) { return ilogbq(x.x_); }
  friend bool isfinite(Quad x) { return finiteq(x.x_) != 0; }
  friend bool isinf(Quad x) { return isinfq(x.x_) != 0; }
  friend bool isnan(Quad x) { return isnanq(x.x_) != 0; }
  friend bool signbit(Quad x) { return signbitq(x.x_) != 0; }

 private:
  Value x_ = 0;
};

template <>
inline constexpr bool multiplied_by_elements<Quad> = true;

}  // namespace stiefel

template <>
class std::numeric_limits<stiefel::Quad> {
  using Quad = stiefel::Quad;

 public:
  static constexpr bool is_specialized = true, is_signed = true, is_integer = false,
                        is_exact = false, is_iec559 = true, is_bounded = true, is_modulo = false,
                        has_infinity = true, has_quiet_NaN = true;
  static constexpr int radix = 2, digits = 113, digits10 = 33, max_digits10 = 36,
                       min_exponent = -16381, max_exponent = 16384, min_exponent10 = -4931,
                       max_exponent10 = 4932;
  static constexpr Quad epsilon() { return 0x1p-112; }
  static constexpr Quad round_error() { return 0.5; }
  static constexpr Quad min() { return 0x1p-16382L; }
  static constexpr Quad max() { return (2 - epsilon()) * 0x1p16383L; }
  static constexpr Quad lowest() { return -max(); }
  static constexpr Quad infinity() { return std::numeric_limits<double>::infinity(); }
  static constexpr Quad quiet_NaN() { return std::numeric_limits<double>::quiet_NaN(); }
};

template <>
struct Eigen::NumTraits<stiefel::Quad> : Eigen::GenericNumTraits<stiefel::Quad> {};
