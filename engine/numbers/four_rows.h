#pragma once

#include "engine/numbers/pack.h"

namespace stiefel {

/// Loads four rows of eight columns of doubles as four packs, and stores them back; consecutive
/// columns start `stride` numbers apart. Faster than single loads on machines with shuffle
/// instructions.
template <Isa isa>
struct FourRows {
  using P = Pack<double, isa>;
  using Four [[gnu::vector_size(32)]] = double;
  using UnalignedFour [[gnu::vector_size(32), gnu::aligned(8)]] = double;
  static constexpr bool fast = isa != Isa::baseline;

  [[gnu::always_inline]] static void load(const double* x, std::ptrdiff_t stride, P (&rows)[4]) {
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k) {
      const Four left = *reinterpret_cast<const UnalignedFour*>(x + k * stride);
      const Four right = *reinterpret_cast<const UnalignedFour*>(x + (k + 4) * stride);
      if constexpr (P::parts == 1) {
        rows[k].v[0] = __builtin_shufflevector(left, right, 0, 1, 2, 3, 4, 5, 6, 7);
      } else {
        rows[k].v[0] = left;
        rows[k].v[1] = right;
      }
    }
    transpose(rows);
  }

  [[gnu::always_inline]] static void store(P (&rows)[4], double* x, std::ptrdiff_t stride) {
    transpose(rows);
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k) {
      UnalignedFour* left = reinterpret_cast<UnalignedFour*>(x + k * stride);
      UnalignedFour* right = reinterpret_cast<UnalignedFour*>(x + (k + 4) * stride);
      if constexpr (P::parts == 1) {
        *left = __builtin_shufflevector(rows[k].v[0], rows[k].v[0], 0, 1, 2, 3);
        *right = __builtin_shufflevector(rows[k].v[0], rows[k].v[0], 4, 5, 6, 7);
      } else {
        *left = rows[k].v[0];
        *right = rows[k].v[1];
      }
    }
  }

 private:
  /// Transposes the two 4 × 4 halves of the lanes.
  [[gnu::always_inline]] static void transpose(P (&x)[4]) {
#pragma GCC unroll 2
    for (int p = 0; p < P::parts; ++p) {
      const auto a = even(x[0].v[p], x[1].v[p]), b = odd(x[0].v[p], x[1].v[p]);
      const auto c = even(x[2].v[p], x[3].v[p]), d = odd(x[2].v[p], x[3].v[p]);
      x[0].v[p] = low(a, c);
      x[1].v[p] = low(b, d);
      x[2].v[p] = high(a, c);
      x[3].v[p] = high(b, d);
    }
  }

  using Part = typename P::Part;
  [[gnu::always_inline]] static Part even(Part a, Part b) {
    if constexpr (P::parts == 1)
      return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    else
      return __builtin_shufflevector(a, b, 0, 4, 2, 6);
  }
  [[gnu::always_inline]] static Part odd(Part a, Part b) {
    if constexpr (P::parts == 1)
      return __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
    else
      return __builtin_shufflevector(a, b, 1, 5, 3, 7);
  }
  [[gnu::always_inline]] static Part low(Part a, Part b) {
    if constexpr (P::parts == 1)
      return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
    else
      return __builtin_shufflevector(a, b, 0, 1, 4, 5);
  }
  [[gnu::always_inline]] static Part high(Part a, Part b) {
    if constexpr (P::parts == 1)
      return __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
    else
      return __builtin_shufflevector(a, b, 2, 3, 6, 7);
  }
};

}  // namespace stiefel
