#pragma once

#include "engine/numbers/lanes.h"

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

}  // namespace stiefel
