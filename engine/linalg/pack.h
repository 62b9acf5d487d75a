#pragma once

#include <cstddef>
#include <type_traits>

#include "engine/linalg/isa.h"

namespace stiefel {

/// Four numbers that are computed with at once, element by element, as the compiler's own vectors:
/// one AVX2 register or two SSE2 ones of doubles. Of a Scalar that no vector holds, one number.
template <class Scalar_, Isa isa>
struct Pack {
  using Scalar = Scalar_;
  static constexpr int lanes = std::is_floating_point_v<Scalar> ? 4 : 1;

  template <class T, bool>
  struct LanesOf {
    using type = T;
    using unaligned = T;
  };
  template <class T>
  struct LanesOf<T, true> {
    using type [[gnu::vector_size(4 * sizeof(T))]] = T;
    using unaligned [[gnu::vector_size(4 * sizeof(T)), gnu::aligned(sizeof(T))]] = T;
  };
  using Lanes = typename LanesOf<Scalar, (lanes > 1)>::type;
  using Unaligned = typename LanesOf<Scalar, (lanes > 1)>::unaligned;

  Lanes v;

  [[gnu::always_inline]] static Pack zero() { return {Lanes{}}; }
  [[gnu::always_inline]] static Pack load(const Scalar* x) {
    return {*reinterpret_cast<const Unaligned*>(x)};
  }
  [[gnu::always_inline]] void store(Scalar* x) const { *reinterpret_cast<Unaligned*>(x) = v; }

  /// One number of each of `lanes` columns that start `stride` numbers apart.
  [[gnu::always_inline]] static Pack gather(const Scalar* x, std::ptrdiff_t stride) {
    if constexpr (lanes == 1)
      return {x[0]};
    else
      return {Lanes{x[0], x[stride], x[2 * stride], x[3 * stride]}};
  }
  [[gnu::always_inline]] void scatter(Scalar* x, std::ptrdiff_t stride) const {
    if constexpr (lanes == 1)
      x[0] = v;
    else
      for (int k = 0; k < 4; ++k) x[k * stride] = v[k];
  }

  [[gnu::always_inline]] Scalar sum() const {
    if constexpr (lanes == 1)
      return v;
    else
      return (v[0] + v[1]) + (v[2] + v[3]);
  }

  [[gnu::always_inline]] friend Pack operator+(Pack a, Pack b) { return {a.v + b.v}; }
  [[gnu::always_inline]] friend Pack operator-(Pack a, Pack b) { return {a.v - b.v}; }
  [[gnu::always_inline]] friend Pack operator*(Pack a, Pack b) { return {a.v * b.v}; }
  [[gnu::always_inline]] friend Pack operator*(Scalar a, Pack b) { return {a * b.v}; }

  /// Whether the machine has shuffles that are worth more than `gather`.
  static constexpr bool transposes =
      lanes == 4 && isa != Isa::baseline && std::is_same_v<Scalar, double>;

  /// The 4 × 4 numbers of four packs, transposed in place.
  [[gnu::always_inline]] static void transpose(Pack (&x)[4]) requires transposes {
    using Order [[gnu::vector_size(4 * sizeof(long))]] = long;
    const auto pick = [](Lanes a, Lanes b, Order order) __attribute__((always_inline)) {
      return __builtin_shuffle(a, b, order);
    };
    const Lanes even = pick(x[0].v, x[1].v, Order{0, 4, 2, 6});
    const Lanes odd = pick(x[0].v, x[1].v, Order{1, 5, 3, 7});
    const Lanes even2 = pick(x[2].v, x[3].v, Order{0, 4, 2, 6});
    const Lanes odd2 = pick(x[2].v, x[3].v, Order{1, 5, 3, 7});
    x[0].v = pick(even, even2, Order{0, 1, 4, 5});
    x[1].v = pick(odd, odd2, Order{0, 1, 4, 5});
    x[2].v = pick(even, even2, Order{2, 3, 6, 7});
    x[3].v = pick(odd, odd2, Order{2, 3, 6, 7});
  }
};

}  // namespace stiefel
