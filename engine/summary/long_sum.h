#pragma once

#include <cmath>

namespace stiefel {

/// A sum in extended precision that carries the rounding errors of its additions (Neumaier 1974).
/// The relative error of a sum of n < 2³² numbers is about 2⁻⁶⁴. Squares of doubles neither
/// overflow nor underflow in it.
struct LongSum {
  long double sum = 0, carry = 0;

  void add(long double x) {
    const long double next = sum + x;
    carry += std::abs(sum) >= std::abs(x) ? (sum - next) + x : (x - next) + sum;
    sum = next;
  }
  void add(const LongSum& other) {
    add(other.sum);
    carry += other.carry;
  }
  /// Returns the sum; it is not finite if a summand was not.
  long double value() const { return std::isfinite(sum) ? sum + carry : sum; }
};

}  // namespace stiefel
