#pragma once

#include <cmath>

namespace stiefel {

/// A sum with the rounding errors of its additions (Neumaier 1974) in extended precision: of n
/// numbers its relative error is about 2⁻⁶⁴, as long as n is below 2³². Squares of doubles neither
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
  /// Not finite where a number was not.
  long double value() const { return std::isfinite(sum) ? sum + carry : sum; }
};

}  // namespace stiefel
