#pragma once

#include <Eigen/Core>
#include <cmath>

#include "engine/numbers/pack.h"

namespace stiefel {

/// Computes sum and error with a + b = sum + error exactly (Knuth's TwoSum).
template <class T>
[[gnu::always_inline]] inline void two_sum(const T& a, const T& b, T& sum, T& error) {
  sum = a + b;
  const T b_seen = sum - a;
  error = (a - (sum - b_seen)) + (b - b_seen);
}

/// Computes sum and error with a + b = sum + error exactly, for |a| ≥ |b| or a = 0 (Dekker's
/// FastTwoSum).
template <class T>
[[gnu::always_inline]] inline void fast_two_sum(const T& a, const T& b, T& sum, T& error) {
  sum = a + b;
  error = b - (sum - a);
}

/// Computes product and error with ab = product + error exactly, if nothing over- or underflows.
/// Uses one fused operation where the processor has one; otherwise splits a and b into halves, with
/// the same result (Veltkamp; Dekker's TwoProduct).
template <class T>
[[gnu::always_inline]] inline void two_product(const T& a, const T& b, T& product, T& error) {
  product = a * b;
  if constexpr (requires { fused(a, b, product); }) {
    error = fused(a, b, -product);
  } else {
    const T factor = two_to<T>((bits<T> + 1) / 2) + T(1);
    const auto split = [&](const T& x, T& high, T& low) __attribute__((always_inline)) {
      const T shifted = factor * x;
      high = shifted - (shifted - x);
      low = x - high;
    };
    T a_high, a_low, b_high, b_low;
    split(a, a_high, a_low);
    split(b, b_high, b_low);
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
  }
}

/// An unevaluated sum high + low with nearly twice the precision of a T (Dekker 1971). Between
/// operations |low| may be some units in the last place of high, which costs a few bits;
/// `normalized` reduces it to at most half a unit.
template <class T>
struct DoubleWord {
  T high, low;

  DoubleWord() = default;
  [[gnu::always_inline]] DoubleWord(const T& x) : high(x), low(T(0)) {}
  [[gnu::always_inline]] DoubleWord(const T& h, const T& l) : high(h), low(l) {}
  /// Splits a number with more bits than a T.
  template <class Wider>
  requires std::is_same_v<Wider, Extended<T>>
  explicit DoubleWord(const Wider& x)
      : high(static_cast<T>(x)), low(static_cast<T>(x - static_cast<Wider>(high))) {}

  explicit operator T() const { return high + low; }

  [[gnu::always_inline]] DoubleWord normalized() const {
    DoubleWord sum;
    fast_two_sum(high, low, sum.high, sum.low);
    return sum;
  }

  [[gnu::always_inline]] friend DoubleWord operator-(const DoubleWord& a) {
    return {-a.high, -a.low};
  }
  [[gnu::always_inline]] friend DoubleWord operator+(const DoubleWord& a, const DoubleWord& b) {
    DoubleWord sum;
    two_sum(a.high, b.high, sum.high, sum.low);
    sum.low += a.low + b.low;
    return sum;
  }
  [[gnu::always_inline]] friend DoubleWord operator+(const T& a, const DoubleWord& b) {
    DoubleWord sum;
    two_sum(a, b.high, sum.high, sum.low);
    sum.low += b.low;
    return sum;
  }
  [[gnu::always_inline]] friend DoubleWord operator-(const DoubleWord& a, const DoubleWord& b) {
    return a + (-b);
  }
  [[gnu::always_inline]] friend DoubleWord operator*(const DoubleWord& a, const DoubleWord& b) {
    DoubleWord product;
    two_product(a.high, b.high, product.high, product.low);
    product.low += a.high * b.low + a.low * b.high;
    return product;
  }
  [[gnu::always_inline]] friend DoubleWord operator*(const T& a, const DoubleWord& b) {
    DoubleWord product;
    two_product(a, b.high, product.high, product.low);
    product.low += a * b.low;
    return product;
  }
  [[gnu::always_inline]] friend DoubleWord operator/(const DoubleWord& a, const DoubleWord& b) {
    const T quotient = a.high / b.high;
    const DoubleWord rest = a - quotient * b;
    return {quotient, (rest.high + rest.low) / b.high};
  }
  [[gnu::always_inline]] friend DoubleWord sqrt(const DoubleWord& a) {
    using std::sqrt;
    const T root = sqrt(a.high);
    const DoubleWord rest = a - root * DoubleWord(root);
    return {root, (rest.high + rest.low) / (root + root)};
  }
};

/// The scalar in which compensated arithmetic computes the last residuals and increments in three
/// dimensions. It is made of two words of the hardware's type, so that numbers and packs give the
/// same bits.
template <class Scalar>
struct DoubledOf {
  using type = Scalar;
};
template <>
struct DoubledOf<float> {
  using type = DoubleWord<float>;
};
template <>
struct DoubledOf<double> {
  using type = DoubleWord<double>;
};
template <class Scalar, Isa isa, int lanes>
struct DoubledOf<Pack<Scalar, isa, lanes>> {
  using type = DoubleWord<Pack<Scalar, isa, lanes>>;
};
template <class Scalar>
using Doubled = typename DoubledOf<Scalar>::type;

/// Returns the product ab, exact if a double word can hold it.
template <class T>
[[gnu::always_inline]] inline Doubled<T> wide_product(const T& a, const T& b) {
  if constexpr (std::is_same_v<Doubled<T>, T>) {
    return a * b;
  } else {
    Doubled<T> product;
    two_product(a, b, product.high, product.low);
    return product;
  }
}

}  // namespace stiefel

template <class T>
struct Eigen::NumTraits<stiefel::DoubleWord<T>> : Eigen::NumTraits<T> {
  using Real = stiefel::DoubleWord<T>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = Real;
};
