#pragma once

#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace stiefel {

/// A floating-point number with 128 bits in integer arithmetic. The constants of a closed form take
/// a third of the instructions that they take with Quad, whose operations are calls of the
/// compiler's library. Operations cut off bits in place of rounding: the relative error of a
/// quotient or root is below 2⁻¹²⁰, that of the others 2⁻¹²⁶. There is no NaN: a quotient by 0 and
/// the root of a negative number are larger than every other number, like infinity.
///
/// Converts implicitly from every arithmetic type, of finite numbers, and explicitly to a
/// floating-point type, rounding to nearest.
class Number128 {
 public:
  __extension__ using Bits = unsigned __int128;

  constexpr Number128() = default;
  /// Returns 2^(exponent − 128) (2⁶⁴ high + low), where `high` is at least 2⁶³.
  static constexpr Number128 of(int exponent, std::uint64_t high, std::uint64_t low) {
    return {false, exponent, Bits(high) << 64 | low, Normal{}};
  }
  template <std::integral T>
  constexpr Number128(T x) : Number128(x < 0, 64, Bits(x < 0 ? 0 - Word(x) : Word(x)) << 64) {}
  Number128(double x) {
    constexpr Word ones = (Word(1) << 52) - 1;
    const Word word = std::bit_cast<Word>(x);
    const int exponent = static_cast<int>(word >> 52 & 0x7ff);
    if (exponent == 0)  // 0 or subnormal
      *this = Number128(x < 0, -1010, Bits(word & ones) << 64);
    else
      *this = {x < 0, exponent - 1022, Bits((word & ones) << 11 | Word(1) << 63) << 64, Normal{}};
  }
  Number128(long double x) {
    static_assert(std::numeric_limits<long double>::digits <= 64);
    int exponent = 0;
    const long double part = std::frexp(x < 0 ? -x : x, &exponent);  // ½ ≤ part < 1, or 0
    *this = Number128(x < 0, exponent, Bits(static_cast<Word>(part * 0x1p64L)) << 64);
  }

  template <std::floating_point T>
  explicit operator T() const {
    constexpr int digits = std::numeric_limits<T>::digits;
    // the kept bits, one that decides, and one for all that follow
    const Word kept = static_cast<Word>(bits_ >> (128 - digits)),
               rest = static_cast<Word>(bits_ >> (64 - digits + 63)) & 1;
    const Bits below = bits_ << (digits + 1);
    const T rounded = static_cast<T>(kept) + T(rest == 1 && (below != 0 || kept % 2 == 1));
    const int shift = exponent_ - digits;
    const T size = -1000 < shift && shift < 900
                       ? rounded * T(std::bit_cast<double>(Word(1023 + shift) << 52))
                       : std::ldexp(rounded, shift);
    return negative_ ? -size : size;
  }

  friend Number128 operator-(Number128 a) {
    a.negative_ = !a.negative_;
    return a;
  }
  friend Number128 operator+(const Number128& a, const Number128& b) {
    if (a.exponent_ < b.exponent_) return b + a;
    return a.negative_ == b.negative_ ? a.plus(b) : a.minus(b);
  }
  friend Number128 operator-(const Number128& a, const Number128& b) { return a + (-b); }
  friend Number128 operator*(const Number128& a, const Number128& b) {
    const auto [top, next] = product(a.bits_, b.bits_);
    const bool negative = a.negative_ != b.negative_;
    const int exponent = a.exponent_ + b.exponent_;
    if (top >> 127) return {negative, exponent, top, Normal{}};
    if (top == 0) return {};
    return {negative, exponent - 1, top << 1 | next >> 63, Normal{}};
  }
  friend Number128 operator/(const Number128& a, const Number128& b) {
    if (b.bits_ == 0) return {a.negative_, endless, Bits(1) << 127, Normal{}};
    const long double inverse = 1 / static_cast<long double>(b.high());
    const Number128 first = a.over(b, inverse);
    return first + (a - first * b).over(b, inverse);
  }
  Number128& operator+=(const Number128& b) { return *this = *this + b; }
  Number128& operator-=(const Number128& b) { return *this = *this - b; }
  Number128& operator*=(const Number128& b) { return *this = *this * b; }
  Number128& operator/=(const Number128& b) { return *this = *this / b; }

  friend bool operator==(const Number128& a, const Number128& b) { return a.order(b) == 0; }
  friend auto operator<=>(const Number128& a, const Number128& b) { return a.order(b) <=> 0; }

  friend Number128 abs(Number128 x) {
    x.negative_ = false;
    return x;
  }
  friend Number128 copysign(Number128 x, const Number128& sign) {
    x.negative_ = sign.negative_;
    return x;
  }
  /// Returns 2^k x.
  friend Number128 ldexp(Number128 x, int k) {
    if (x.bits_ != 0) x.exponent_ += k;
    return x;
  }
  /// Returns the nearest number with so many bits, fewer than 128, as an operation of Quad does
  /// with 113; of two, the even one.
  Number128 rounded(int digits) const {
    const Bits unit = Bits(1) << (128 - digits), rest = bits_ & (unit - 1), kept = bits_ - rest;
    const bool up = rest > unit / 2 || (rest == unit / 2 && (kept & unit) != 0);
    if (up && kept + unit == 0) return {negative_, exponent_ + 1, Bits(1) << 127, Normal{}};
    return {negative_, exponent_, up ? kept + unit : kept, Normal{}};
  }
  friend Number128 sqrt(const Number128& x) {
    if (x.bits_ == 0) return x;
    if (x.negative_) return x / 0;
    const bool odd = x.exponent_ % 2 != 0;
    const auto first = static_cast<long double>(x.high());
    const long double root = std::sqrt(odd ? 2 * first : first);  // below 2^32.5
    const Number128 y(false, (x.exponent_ - odd) / 2 + 2,
                      Bits(static_cast<Word>(std::llrint(root * 0x1p30L))) << 64);
    return y + ldexp((x - y * y).over(y, 1 / static_cast<long double>(y.high())), -1);
  }
  friend Number128 exp(const Number128& x);
  friend Number128 atan(const Number128& x);
  /// Returns the cosine and sine of x, |x| < 1.
  friend std::pair<Number128, Number128> cosine_sine(const Number128& x);

 private:
  using Word = std::uint64_t;
  struct Normal {};
  static constexpr int endless = 1 << 28;

  constexpr Number128(bool negative, int exponent, Bits bits, Normal)
      : negative_(negative), exponent_(exponent), bits_(bits) {}
  constexpr Number128(bool negative, int exponent, Bits bits)
      : negative_(negative), exponent_(exponent), bits_(bits) {
    if (bits == 0) {
      *this = {};
      return;
    }
    const int zeros = high() != 0 ? std::countl_zero(high()) : 64 + std::countl_zero(low());
    bits_ <<= zeros;
    exponent_ -= zeros;
  }

  constexpr Word high() const { return static_cast<Word>(bits_ >> 64); }
  constexpr Word low() const { return static_cast<Word>(bits_); }

  /// Returns the first 192 bits of a product.
  static constexpr std::pair<Bits, Word> product(Bits a, Bits b) {
    const Word a_1 = Word(a >> 64), a_0 = Word(a), b_1 = Word(b >> 64), b_0 = Word(b);
    const Bits p_10 = Bits(a_1) * b_0, p_01 = Bits(a_0) * b_1;
    const Bits middle = (Bits(a_0) * b_0 >> 64) + Word(p_10) + Word(p_01);
    return {Bits(a_1) * b_1 + (p_10 >> 64) + (p_01 >> 64) + (middle >> 64), Word(middle)};
  }
  /// Returns 2¹²⁸|x| of a number |x| < 1, and the number of such a part of 2¹²⁸.
  Bits part() const { return exponent_ > -128 ? bits_ >> -exponent_ : 0; }
  static Number128 of_part(Bits part) { return {false, 0, part}; }
  /// Returns small atan d, |d| ≤ 1/32.
  static Number128 small_atan(const Number128& d);
  /// Returns a quotient with about 61 bits; `inverse` is that of b.high().
  Number128 over(const Number128& b, long double inverse) const {
    const long double quotient = static_cast<long double>(high()) * inverse;  // ½ < · < 2, or 0
    return {negative_ != b.negative_, exponent_ - b.exponent_ + 2,
            Bits(static_cast<Word>(std::llrint(quotient * 0x1p62L))) << 64};
  }
  /// Returns the sum with a number of the same sign and no larger exponent.
  Number128 plus(const Number128& b) const {
    const int shift = exponent_ - b.exponent_;
    if (shift > 127 || b.bits_ == 0) return *this;
    const Bits sum = bits_ + (b.bits_ >> shift);
    if (sum >= bits_) return {negative_, exponent_, sum, Normal{}};
    return {negative_, exponent_ + 1, sum >> 1 | Bits(1) << 127, Normal{}};
  }
  /// Returns the sum with a number of the other sign and no larger exponent. One bit that `shift`
  /// cuts off counts, so that numbers that nearly cancel have an exact sum.
  Number128 minus(const Number128& b) const {
    const int shift = exponent_ - b.exponent_;
    if (shift > 127 || b.bits_ == 0) return *this;
    if (shift == 0)
      return bits_ < b.bits_ ? Number128(!negative_, exponent_, b.bits_ - bits_)
                             : Number128(negative_, exponent_, bits_ - b.bits_);
    const Bits next = b.bits_ >> (shift - 1) & 1, rest = bits_ - (b.bits_ >> shift) - next;
    if (rest >> 127) return {negative_, exponent_, rest, Normal{}};
    return {negative_, exponent_ - 1, rest << 1 | next};
  }
  int sign() const { return bits_ == 0 ? 0 : negative_ ? -1 : 1; }
  int order(const Number128& b) const {
    if (sign() != b.sign() || bits_ == 0) return sign() - b.sign();
    if (exponent_ != b.exponent_) return exponent_ < b.exponent_ ? -sign() : sign();
    return bits_ == b.bits_ ? 0 : bits_ < b.bits_ ? -sign() : sign();
  }

  bool negative_ = false;
  int exponent_ = -(1 << 29);  ///< that of 0 is below all others
  Bits bits_ = 0;  ///< the size is bits · 2^(exponent − 128); the first bit is 1, or all 0
};

inline constexpr Number128 pi_128 = Number128::of(2, 0xC90FDAA22168C234, 0xC4C6628B80DC1CD1),
                           inverse_pi_128 =
                               Number128::of(-1, 0xA2F9836E4E441529, 0xFC2757D1F534DDC0);

}  // namespace stiefel

template <>
class std::numeric_limits<stiefel::Number128> : public std::numeric_limits<long double> {
 public:
  static constexpr int digits = 120;
};

template <>
struct Eigen::NumTraits<stiefel::Number128> : Eigen::GenericNumTraits<stiefel::Number128> {};
