#pragma once

#include <boost/multiprecision/eigen.hpp>
#include <boost/multiprecision/float128.hpp>

namespace stiefel::testing {

/// IEEE quadruple precision, 113 bits.
using Quad = boost::multiprecision::float128;

}  // namespace stiefel::testing

/// Without the compiler's extensions Boost's own definitions of these two do not compile.
template <>
constexpr stiefel::testing::Quad std::numeric_limits<stiefel::testing::Quad>::min() noexcept {
  return boost::multiprecision::backends::float128_backend(
      boost::multiprecision::quad_constants::quad_min);
}
template <>
constexpr stiefel::testing::Quad std::numeric_limits<stiefel::testing::Quad>::max() noexcept {
  return boost::multiprecision::backends::float128_backend(
      boost::multiprecision::quad_constants::quad_max);
}

namespace boost::multiprecision {
/// Nor does this one.
inline float128 asinh(const float128& x) {
  return float128(backends::float128_backend(asinhq(x.backend().value())));
}
}  // namespace boost::multiprecision

/// Boost's own has no infinity, which Eigen's eigensolvers ask for.
template <>
struct Eigen::NumTraits<stiefel::testing::Quad> : Eigen::GenericNumTraits<stiefel::testing::Quad> {
};
