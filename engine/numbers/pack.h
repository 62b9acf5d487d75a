#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>

#ifdef STIEFEL_X86_64
#include <immintrin.h>
#endif

#include "engine/numbers/isa.h"
#include "engine/numbers/scalar.h"

namespace stiefel {

/// Returns how many Scalars a register holds.
template <class Scalar>
constexpr int vector_width(Isa isa) {
  return (isa == Isa::avx512 ? 64 : isa == Isa::avx2 ? 32 : 16) / static_cast<int>(sizeof(Scalar));
}

/// A vector of `lanes` numbers, computed element by element in the compiler's vector types: eight
/// doubles are one register of AVX-512 or two of AVX2. A Scalar without a vector type has one lane.
template <class Scalar_, Isa isa, int lanes_ = 8>
struct Pack {
  using Scalar = Scalar_;
  static constexpr bool vectors = std::is_floating_point_v<Scalar>;
  static constexpr int lanes = vectors ? lanes_ : 1;
  static constexpr int width = vectors ? std::min(vector_width<Scalar>(isa), lanes) : 1;
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

  /// The result of a comparison: in each lane all bits are set, or none.
  struct Mask {
    using Part = decltype(typename VectorOf<Scalar, width>::type{} <
                          typename VectorOf<Scalar, width>::type{});
    static constexpr unsigned every_lane = (1u << lanes) - 1;

    Part v[parts];

    template <class Make>
    [[gnu::always_inline]] static Mask of_parts(Make&& make) {
      Mask m;
#pragma GCC unroll 4
      for (int p = 0; p < parts; ++p) m.v[p] = make(p);
      return m;
    }
    [[gnu::always_inline]] friend Mask operator&(Mask a, Mask b) {
      return of_parts([&](int p) __attribute__((always_inline))->Part { return a.v[p] & b.v[p]; });
    }
    [[gnu::always_inline]] friend Mask operator|(Mask a, Mask b) {
      return of_parts([&](int p) __attribute__((always_inline))->Part { return a.v[p] | b.v[p]; });
    }
    /// Returns the lanes that are set: bit k is lane k.
    [[gnu::always_inline]] unsigned lanes_set() const {
      unsigned bits = 0;
#pragma GCC unroll 4
      for (int p = 0; p < parts; ++p) bits |= signs(v[p]) << (p * width);
      return bits;
    }

   private:
    /// Returns the signs of the elements: bit k is set if element k is negative.
    [[gnu::always_inline]] static unsigned signs(Part part) {
#ifdef STIEFEL_X86_64
      if constexpr (std::is_same_v<Scalar, double> && width == 8)
        return __builtin_ia32_cvtq2mask512(reinterpret_cast<__v8di>(part));
      else if constexpr (std::is_same_v<Scalar, double> && width == 4)
        return static_cast<unsigned>(__builtin_ia32_movmskpd256(reinterpret_cast<__v4df>(part)));
      else if constexpr (std::is_same_v<Scalar, double> && width == 2)
        return static_cast<unsigned>(__builtin_ia32_movmskpd(reinterpret_cast<__v2df>(part)));
      else if constexpr (std::is_same_v<Scalar, float> && width == 16)
        return __builtin_ia32_cvtd2mask512(reinterpret_cast<__v16si>(part));
      else if constexpr (std::is_same_v<Scalar, float> && width == 8)
        return static_cast<unsigned>(__builtin_ia32_movmskps256(reinterpret_cast<__v8sf>(part)));
      else if constexpr (std::is_same_v<Scalar, float> && width == 4)
        return static_cast<unsigned>(__builtin_ia32_movmskps(reinterpret_cast<__v4sf>(part)));
#endif
      unsigned bits = 0;
      for (int k = 0; k < width; ++k) bits |= (part[k] < 0 ? 1u : 0u) << k;
      return bits;
    }
  };

  Part v[parts];

  Pack() = default;
  /// Every lane holds x.
  [[gnu::always_inline]] Pack(Scalar x) {
#pragma GCC unroll 4
    for (int p = 0; p < parts; ++p) v[p] = x - Part{};
  }

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

  /// Puts make(k) into lane k.
  template <class Make>
  [[gnu::always_inline]] static Pack of_lanes(Make&& make) {
    Scalar all[lanes];
    for (int k = 0; k < lanes; ++k) all[k] = static_cast<Scalar>(make(k));
    return load(all);
  }
  /// Loads one number from each of `lanes` columns; consecutive columns start `stride` numbers
  /// apart.
  template <class T>
  [[gnu::always_inline]] static Pack gather(const T* x, std::ptrdiff_t stride) {
    Scalar all[lanes];
    for (int k = 0; k < lanes; ++k) all[k] = static_cast<Scalar>(x[k * stride]);
    return load(all);
  }
  /// Stores one number into each of `lanes` columns, which start `stride` numbers apart; only from
  /// lanes whose bits in `set` are 1.
  template <class T>
  [[gnu::always_inline]] void scatter(T* x, std::ptrdiff_t stride,
                                      unsigned set = Mask::every_lane) const {
    Scalar all[lanes];
    store(all);
    for (int k = 0; k < lanes; ++k)
      if (set >> k & 1) x[k * stride] = all[k];
  }

  /// Reads and writes one lane of a vector.
  [[gnu::always_inline]] Scalar operator[](int k) const { return v[k / width][k % width]; }
  [[gnu::always_inline]] void set(int k, Scalar x) { v[k / width][k % width] = x; }

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
  [[gnu::always_inline]] friend Pack operator/(Pack a, Pack b) {
    return of_parts([&](int p) __attribute__((always_inline))->Part { return a.v[p] / b.v[p]; });
  }
  [[gnu::always_inline]] friend Pack operator-(Pack a) {
    return of_parts([&](int p) __attribute__((always_inline))->Part { return -a.v[p]; });
  }
  [[gnu::always_inline]] Pack& operator+=(Pack b) { return *this = *this + b; }
  [[gnu::always_inline]] Pack& operator-=(Pack b) { return *this = *this - b; }
  [[gnu::always_inline]] Pack& operator*=(Pack b) { return *this = *this * b; }
  [[gnu::always_inline]] Pack& operator/=(Pack b) { return *this = *this / b; }
  [[gnu::always_inline]] friend Pack ldexp(Pack a, int k) {
    return a * Pack(static_cast<Scalar>(__builtin_ldexp(1, k)));
  }
  [[gnu::always_inline]] friend Pack sqrt(Pack a) {
    return of_parts([&](int p) __attribute__((always_inline)) {
      Part root;
#pragma GCC unroll 16
      for (int k = 0; k < width; ++k) root[k] = square_root(a.v[p][k]);
      return root;
    });
  }

  /// ab + c, rounded once.
  [[gnu::always_inline]] friend Pack fused(Pack a, Pack b, Pack c) requires(isa != Isa::baseline) {
    return of_parts([&](int p) __attribute__((always_inline)) {
#ifdef STIEFEL_X86_64
      // The compiler does not put all products of elements together again.
      if constexpr (std::is_same_v<Scalar, double> && width == 8)
        return reinterpret_cast<Part>(_mm512_fmadd_pd(a.v[p], b.v[p], c.v[p]));
      else if constexpr (std::is_same_v<Scalar, double> && width == 4)
        return reinterpret_cast<Part>(_mm256_fmadd_pd(a.v[p], b.v[p], c.v[p]));
      else
#endif
      {
        Part sum;
#pragma GCC unroll 16
        for (int k = 0; k < width; ++k) sum[k] = fused_element(a.v[p][k], b.v[p][k], c.v[p][k]);
        return sum;
      }
    });
  }

  [[gnu::always_inline]] friend Mask operator<(Pack a, Pack b) {
    return Mask::of_parts([&](int p) __attribute__((always_inline)) { return a.v[p] < b.v[p]; });
  }
  [[gnu::always_inline]] friend Mask operator<=(Pack a, Pack b) {
    return Mask::of_parts([&](int p) __attribute__((always_inline)) { return a.v[p] <= b.v[p]; });
  }
  /// a where the mask is set, else b.
  [[gnu::always_inline]] friend Pack select(Mask m, Pack a, Pack b) {
    return of_parts([&](int p) __attribute__((always_inline))->Part {
      return m.v[p] ? a.v[p] : b.v[p];
    });
  }

 private:
  // Compiler builtins: a function of <cmath> that is not inlined here would be compiled for this
  // instruction set, and the linker could use it in code for other machines.
  [[gnu::always_inline]] static float square_root(float x) { return __builtin_sqrtf(x); }
  [[gnu::always_inline]] static double square_root(double x) { return __builtin_sqrt(x); }
  [[gnu::always_inline]] static float fused_element(float a, float b, float c) {
    return __builtin_fmaf(a, b, c);
  }
  [[gnu::always_inline]] static double fused_element(double a, double b, double c) {
    return __builtin_fma(a, b, c);
  }
};

/// The type of the result of comparing two Scalars: bool for a number, one truth value for each
/// lane for a pack. `all` and `select` replace branches, so that one source serves numbers and
/// packs.
template <class Scalar>
struct MaskOf {
  using type = bool;
};
template <class Scalar, Isa isa, int lanes>
struct MaskOf<Pack<Scalar, isa, lanes>> {
  using type = typename Pack<Scalar, isa, lanes>::Mask;
};
template <class Scalar>
using Mask = typename MaskOf<Scalar>::type;

/// Whether the condition holds in every lane.
[[gnu::always_inline]] inline bool all(bool condition) { return condition; }
template <class LaneMask>
[[gnu::always_inline]] inline bool all(const LaneMask& mask) {
  return mask.lanes_set() == LaneMask::every_lane;
}

/// Returns a where the condition holds, else b.
template <class T>
[[gnu::always_inline]] inline T select(bool condition, const T& a, const T& b) {
  return condition ? a : b;
}
template <class Scalar, Isa isa, int lanes>
[[gnu::always_inline]] inline auto select(const typename Pack<Scalar, isa, lanes>::Mask& mask,
                                          const Vector3<Pack<Scalar, isa, lanes>>& a,
                                          const Vector3<Pack<Scalar, isa, lanes>>& b) {
  return Vector3<Pack<Scalar, isa, lanes>>(select(mask, a(0), b(0)), select(mask, a(1), b(1)),
                                           select(mask, a(2), b(2)));
}

/// The number of bits of each number in a pack.
template <class Scalar, Isa isa, int lanes>
inline constexpr int bits<Pack<Scalar, isa, lanes>> = bits<Scalar>;

}  // namespace stiefel

/// Lets Eigen use packs as scalars.
template <class Scalar_, stiefel::Isa isa, int lanes>
struct Eigen::NumTraits<stiefel::Pack<Scalar_, isa, lanes>> {
  using Real = stiefel::Pack<Scalar_, isa, lanes>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = Real;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1,
  };
};
