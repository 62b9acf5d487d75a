#pragma once

#include "engine/numbers/double_word.h"
#include "stiefel/arithmetic.h"

namespace stiefel {

/// A sum over many steps: `value` alone (plain), or `value` + `carry` (compensated), where the
/// carry holds the rounding errors of the additions. `Block` is any dense Eigen type.
template <class Block>
struct Accumulator {
  using Scalar = typename Block::Scalar;

  Block value;
  Block carry;  ///< without meaning in plain arithmetic
  bool compensated = false;

  Accumulator() = default;
  Accumulator(const Block& start, Arithmetic arithmetic)
      : value(start), carry(start), compensated(arithmetic == Arithmetic::compensated) {
    if (compensated) carry.setZero();
  }

  /// Copies what the arithmetic uses of a sum in the same arithmetic.
  [[gnu::always_inline]] void assign(const Accumulator& other) {
    value = other.value;
    if (compensated) carry = other.carry;
  }

  /// Returns the data of the carry; null in plain arithmetic.
  Scalar* carry_data() { return compensated ? carry.data() : nullptr; }

  /// Returns element (i, j) with its carry.
  Extended<Scalar> extended(Eigen::Index i, Eigen::Index j = 0) const {
    Extended<Scalar> x = value(i, j);
    if (compensated) x += carry(i, j);
    return x;
  }

  /// Returns element (i, j) with its carry; for compensated arithmetic.
  Extended<Scalar> with_carry(Eigen::Index i, Eigen::Index j) const {
    return Extended<Scalar>(value(i, j)) + carry(i, j);
  }

  /// Adds to one element an increment that is itself more accurate than a Scalar.
  void add(Eigen::Index i, Eigen::Index j, Extended<Scalar> increment) {
    if (compensated)
      add_with_carry(i, j, increment);
    else
      value(i, j) += static_cast<Scalar>(increment);
  }

  /// Returns element i with its carry as a double word. The `add` for double words takes an
  /// increment of the same type. Both are for compensated arithmetic.
  Doubled<Scalar> doubled(Eigen::Index i) const {
    if constexpr (!std::is_same_v<Doubled<Scalar>, Scalar>)
      return {value(i), carry(i)};
    else
      return extended(i);
  }
  void add(Eigen::Index i, const DoubleWord<Scalar>& increment) {
    const DoubleWord<Scalar> sum = (value(i) + (carry(i) + increment)).normalized();
    value(i) = sum.high;
    carry(i) = sum.low;
  }
  void add(Eigen::Index i,
           const Extended<Scalar>& increment) requires std::is_same_v<Doubled<Scalar>, Scalar> {
    add(i, 0, increment);
  }

  /// Adds an increment that is as accurate as a Scalar.
  void add_scalar(Eigen::Index i, Eigen::Index j, Scalar increment) {
    if (compensated)
      add_scalar_with_carry(i, j, increment);
    else
      value(i, j) += increment;
  }

  template <class Increment>
  void add(const Eigen::MatrixBase<Increment>& increment) {
    if (!compensated) {
      for (Eigen::Index j = 0; j < value.cols(); ++j)
        for (Eigen::Index i = 0; i < value.rows(); ++i) value(i, j) += increment(i, j);
      return;
    }
    for (Eigen::Index j = 0; j < value.cols(); ++j)
      for (Eigen::Index i = 0; i < value.rows(); ++i) add_scalar_with_carry(i, j, increment(i, j));
  }

  /// Sets element (k, l) to minus element (i, j), which completes a skew block.
  void mirror(Eigen::Index i, Eigen::Index j, Eigen::Index k, Eigen::Index l) {
    value(k, l) = -value(i, j);
    if (compensated) carry(k, l) = -carry(i, j);
  }

  /// Calls `visit` with each block of numbers, for saving and restoring.
  template <class Visitor>
  void each(Visitor&& visit) {
    visit(value);
    if (compensated) visit(carry);
  }

  // For compensated arithmetic:

  void add_with_carry(Eigen::Index i, Eigen::Index j, Extended<Scalar> increment) {
    const Extended<Scalar> sum = value(i, j) + (carry(i, j) + increment);
    value(i, j) = static_cast<Scalar>(sum);
    carry(i, j) = static_cast<Scalar>(sum - value(i, j));
  }

  void add_scalar_with_carry(Eigen::Index i, Eigen::Index j, const Scalar& increment) {
    Scalar sum, error;
    two_sum(value(i, j), carry(i, j) + increment, sum, error);
    value(i, j) = sum;
    carry(i, j) = error;
  }
};

}  // namespace stiefel
