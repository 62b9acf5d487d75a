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
    Four left[4], right[4];
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k) {
      left[k] = *reinterpret_cast<const UnalignedFour*>(x + k * stride);
      right[k] = *reinterpret_cast<const UnalignedFour*>(x + (k + 4) * stride);
    }
    transpose(left);
    transpose(right);
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k)
      if constexpr (P::parts == 1)
        rows[k].v[0] = __builtin_shufflevector(left[k], right[k], 0, 1, 2, 3, 4, 5, 6, 7);
      else
        rows[k].v[0] = left[k], rows[k].v[1] = right[k];
  }

  [[gnu::always_inline]] static void store(P (&rows)[4], double* x, std::ptrdiff_t stride) {
    Four left[4], right[4];
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k)
      if constexpr (P::parts == 1) {
        left[k] = __builtin_shufflevector(rows[k].v[0], rows[k].v[0], 0, 1, 2, 3);
        right[k] = __builtin_shufflevector(rows[k].v[0], rows[k].v[0], 4, 5, 6, 7);
      } else {
        left[k] = rows[k].v[0], right[k] = rows[k].v[1];
      }
    transpose(left);
    transpose(right);
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k) {
      *reinterpret_cast<UnalignedFour*>(x + k * stride) = left[k];
      *reinterpret_cast<UnalignedFour*>(x + (k + 4) * stride) = right[k];
    }
  }

 private:
  [[gnu::always_inline]] static void transpose(Four (&x)[4]) {
    const Four a = __builtin_shufflevector(x[0], x[1], 0, 4, 2, 6),
               b = __builtin_shufflevector(x[0], x[1], 1, 5, 3, 7),
               c = __builtin_shufflevector(x[2], x[3], 0, 4, 2, 6),
               d = __builtin_shufflevector(x[2], x[3], 1, 5, 3, 7);
    x[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    x[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    x[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    x[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
  }
};

}  // namespace stiefel
