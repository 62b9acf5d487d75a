#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace stiefel {

/// A decimal fraction of 36 digits in three groups of twelve, enough for quadruple precision.
struct Decimal36 {
  std::int64_t first, second, third;

  template <class Scalar>
  Scalar as() const {
    const Scalar group = 1e12;
    return Scalar(first) / group + (Scalar(second) + Scalar(third) / group) / (group * group);
  }
};

/// Returns the first half γ_1, …, γ_{(s+1)/2} of the palindromic composition of s stages that turns
/// a symmetric map of order 2 into one of order 2, 4, 6 or 8:
///
///     4: s = 5, γ = (p, p, 1 − 4p, p, p), p = 1/(4 − 4^{1/3}) (Suzuki 1990);
///     6: s = 9, 8: s = 17 (Kahan and Li 1997).
///
/// The middle γ is 1 minus the sum of the others. The digits satisfy the order conditions to 1e-36.
/// Order 6 was published with fewer digits; the values here are the nearest point of its
/// one-parameter family.
template <class Scalar>
std::vector<Scalar> symmetric_stages(int order) {
  static constexpr std::array<Decimal36, 4> order6 = {{
      {392161444007, 314139279250, 557422671404},
      {332599136789, 359438599748, 637500049647},
      {-706246172557, -639359809964, -819549256459},
      {82213596293, 550800231490, 448102056331},
  }};
  static constexpr std::array<Decimal36, 8> order8 = {{
      {130202483088, 890080878817, 630000000000},
      {561162981775, 108384561964, 407682000103},
      {-389474962644, -847286408078, -593043166997},
      {158841906555, 155600896210, 746677682393},
      {-395903894133, -237577336231, -543466131671},
      {184539640978, 315707091832, 543364086516},
      {258374387686, 322047293979, 111695425974},
      {295011723609, 310298870966, 236757462977},
  }};
  std::vector<Scalar> gamma;
  const auto take = [&](const auto& digits) {
    for (const Decimal36& d : digits) gamma.push_back(d.template as<Scalar>());
  };
  using std::pow;
  switch (order) {
    case 2:
      break;
    case 4:
      gamma.assign(2, 1 / (4 - pow(Scalar(4), Scalar(1) / 3)));
      break;
    case 6:
      take(order6);
      break;
    case 8:
      take(order8);
      break;
    default:
      throw std::invalid_argument("order: 2, 4, 6 or 8");
  }
  Scalar middle = 1;
  for (const Scalar& g : gamma) middle -= 2 * g;
  gamma.push_back(middle);
  return gamma;
}

}  // namespace stiefel
