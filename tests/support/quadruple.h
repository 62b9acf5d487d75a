#pragma once

#include "engine/linalg/quadruple.h"

namespace stiefel::testing {

using stiefel::Quad;

}  // namespace stiefel::testing

namespace boost::multiprecision {
/// Without the compiler's extensions Boost's own does not compile.
inline float128 asinh(const float128& x) {
  return float128(backends::float128_backend(asinhq(x.backend().value())));
}
}  // namespace boost::multiprecision
