#pragma once

#include <cstddef>
#include <type_traits>

#include "engine/linalg/isa.h"

namespace stiefel {

/// Eight numbers that are computed with at once, element by element, in the compiler's own vectors:
/// of doubles one register of AVX-512 or two of AVX2. Of a Scalar that no vector holds, one number.
template <class Scalar_, Isa isa>
struct Pack {
  using Scalar = Scalar_;
  static constexpr bool vectors = std::is_floating_point_v<Scalar>;
  static constexpr int lanes = vectors ? 8 : 1;
  static constexpr int width = !vectors             ? 1
                               : isa == Isa::avx512 ? 8
                               : isa == Isa::avx2   ? 4
                                                    : 2;  ///< of a vector
  static constexpr int parts = lanes / width;

  template <class T, int count>
  struct VectorOf {
    using type [[gnu::vector_size(count * sizeof(T))]] = T;
    using unaligned [[gnu::vector_size(count * sizeof(T)), gnu::aligned(sizeof(T))]] = T;
  };
  template <class T>
  struct VectorOf<T, 1> {
    using type = T;
    using unaligned = T;
  };
  using Part = typename VectorOf<Scalar, width>::type;
  using UnalignedPart = typename VectorOf<Scalar, width>::unaligned;

  Part v[parts];

  template <class Make>
  [[gnu::always_inline]] static Pack of_parts(Make&& make) {
    Pack x;
#pragma GCC unroll 4
    for (int p = 0; p < parts; ++p) x.v[p] = make(p);
    return x;
  }

  [[gnu::always_inline]] static Pack zero() {
    return of_parts([](int) __attribute__((always_inline)) { return Part{}; });
  }
  [[gnu::always_inline]] static Pack load(const Scalar* x) {
    return of_parts([&](int p) __attribute__((always_inline))->Part {
      return *reinterpret_cast<const UnalignedPart*>(x + p * width);
    });
  }
  [[gnu::always_inline]] void store(Scalar* x) const {
#pragma GCC unroll 4
    for (int p = 0; p < parts; ++p) *reinterpret_cast<UnalignedPart*>(x + p * width) = v[p];
  }

  /// One number of each of `lanes` columns that start `stride` numbers apart.
  [[gnu::always_inline]] static Pack gather(const Scalar* x, std::ptrdiff_t stride) {
    Scalar all[lanes];
    for (int k = 0; k < lanes; ++k) all[k] = x[k * stride];
    return load(all);
  }
  [[gnu::always_inline]] void scatter(Scalar* x, std::ptrdiff_t stride) const {
    Scalar all[lanes];
    store(all);
    for (int k = 0; k < lanes; ++k) x[k * stride] = all[k];
  }

  [[gnu::always_inline]] Scalar sum() const {
    Scalar all[lanes];
    store(all);
    for (int half = lanes / 2; half > 0; half /= 2)
      for (int k = 0; k < half; ++k) all[k] += all[k + half];
    return all[0];
  }

  [[gnu::always_inline]] friend Pack operator+(Pack a, Pack b) {
    return of_parts([&](int p) __attribute__((always_inline))->Part { return a.v[p] + b.v[p]; });
  }
  [[gnu::always_inline]] friend Pack operator-(Pack a, Pack b) {
    return of_parts([&](int p) __attribute__((always_inline))->Part { return a.v[p] - b.v[p]; });
  }
  [[gnu::always_inline]] friend Pack operator*(Pack a, Pack b) {
    return of_parts([&](int p) __attribute__((always_inline))->Part { return a.v[p] * b.v[p]; });
  }
  [[gnu::always_inline]] friend Pack operator*(Scalar a, Pack b) {
    return of_parts([&](int p) __attribute__((always_inline))->Part { return a * b.v[p]; });
  }
};

}  // namespace stiefel
