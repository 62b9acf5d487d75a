#include "engine/numbers/number_128.h"

#include <array>

namespace stiefel {
namespace {

using Bits = Number128::Bits;
constexpr Number128 ln_2 = Number128::of(0, 0xB17217F7D1CF79AB, 0xC9E3B39803F2F6AF);

/// 2¹²⁸/k!, from k = 2 on.
constexpr auto inverse_factorials = [] {
  std::array<Bits, 34> inverse{};
  Bits factorial = 1;
  for (unsigned k = 2; k < inverse.size(); ++k) inverse[k] = ~Bits(0) / (factorial *= k);
  return inverse;
}();

}  // namespace

/// By the series at x/32, x less a multiple of ln 2, and e^2x − 1 = (e^x − 1)(e^x + 1).
Number128 exp(const Number128& x) {
  const auto& c = inverse_factorials;
  auto n = static_cast<int>(std::floor(static_cast<double>(x) / 0x1.62e42fefa39efp-1));
  Number128 rest = x - n * ln_2;
  if (rest.negative_) {
    rest += ln_2;
    --n;
  }
  const auto times = [](Bits a, Bits b) { return Number128::product(a, b).first; };
  const Bits s = rest.part() >> 5;
  Bits e = c[15];
  for (int k = 14; k > 1; --k) e = times(e, s) + c[k];
  e = s + times(s, times(s, e));
  for (int i = 0; i < 4; ++i) e = 2 * e + times(e, e);
  const Number128 half = Number128::of_part(e) + 1;
  return ldexp(half * half, n);
}

std::pair<Number128, Number128> cosine_sine(const Number128& x) {
  const auto& c = inverse_factorials;
  const auto times = [](Bits a, Bits b) { return Number128::product(a, b).first; };
  const Bits part = x.part(), square = times(part, part);
  Bits cosine = c[32], sine = c[33];
  for (int k = 30; k > 0; k -= 2) {
    cosine = c[k] - times(square, cosine);
    sine = c[k + 1] - times(square, sine);
  }
  return {1 - Number128::of_part(times(square, cosine)),
          x - x * Number128::of_part(times(square, sine))};
}

Number128 Number128::small_atan(const Number128& d) {
  const Bits part = d.part(), square = product(part, part).first;
  Bits sum = ~Bits(0) / 27;
  for (unsigned k = 25; k > 1; k -= 2) sum = ~Bits(0) / k - product(square, sum).first;
  return d - d * of_part(product(square, sum).first);
}

/// By the angle of a multiple of 1/32 and the tangent of a difference.
Number128 atan(const Number128& x) {
  static const auto angles = [] {
    std::array<Number128, 33> angle;
    for (int k = 0; k < 32; ++k)
      angle[k + 1] = angle[k] + Number128::small_atan(Number128(32) / (1024 + k * (k + 1)));
    return angle;
  }();
  const Number128 size = abs(x);
  const bool large = size > 1;
  const auto near = static_cast<int>(32 * static_cast<double>(large ? 1 / size : size) + 0.5);
  // size = p/q: (32 p − near q)/(32 q + near p)
  const Number128 d =
      large ? (32 - near * size) / (32 * size + near) : (32 * size - near) / (32 + near * size);
  const Number128 angle = angles[near] + Number128::small_atan(d);
  return copysign(large ? ldexp(pi_128, -1) - angle : angle, x);
}

}  // namespace stiefel
