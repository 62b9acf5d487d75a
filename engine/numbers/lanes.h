#pragma once

#include <Eigen/Core>

#include "engine/numbers/pack.h"
#include "engine/numbers/scalar.h"

namespace stiefel {

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
