#pragma once

#include <boost/multiprecision/eigen.hpp>
#include <boost/multiprecision/float128.hpp>

namespace stiefel {

/// IEEE quadruple precision, 113 bits.
using Quad = boost::multiprecision::float128;

}  // namespace stiefel

/// Boost's own asinh needs the compiler's extensions, which are switched off here.
namespace boost::multiprecision {
inline float128 asinh(const float128& x) {
  return float128(backends::float128_backend(asinhq(x.backend().value())));
}
}  // namespace boost::multiprecision

template <>
constexpr stiefel::Quad std::numeric_limits<stiefel::Quad>::min() noexcept {
  return boost::multiprecision::backends::float128_backend(
      boost::multiprecision::quad_constants::quad_min);
}
template <>
constexpr stiefel::Quad std::numeric_limits<stiefel::Quad>::max() noexcept {
  return boost::multiprecision::backends::float128_backend(
      boost::multiprecision::quad_constants::quad_max);
}

/// Eigen's eigensolvers need an infinity, which Boost's specialisation does not define.
template <>
struct Eigen::NumTraits<stiefel::Quad> : Eigen::GenericNumTraits<stiefel::Quad> {};
