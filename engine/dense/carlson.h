#pragma once

#include <cmath>

#include "engine/numbers/scalar.h"

/// Carlson's symmetric elliptic integrals by duplication (Carlson 1979, 1995; DLMF 19.36(i)), to
/// the precision of any real Scalar. All terms of every sum are positive.
///
/// Boost.Math's ellint_rc, ellint_rf and ellint_rj are as accurate (special_functions_test.cc): the
/// largest errors found are 5, 6 and 10 ulps, and 5, 7 and 10 ulps here. They are not used, because
/// they do not compile for Quad, and ellint_rj takes twice the time in extended precision.
namespace stiefel::carlson {

/// Returns the largest relative distance ε of the arguments from their mean for which the series is
/// accurate to rounding; its error is of order ε⁸.
template <class Scalar>
Scalar close_enough() {
  return two_to<Scalar>(-(bits<Scalar> + 7) / 8);
}

/// Returns R_C(x, y) = ½ ∫₀^∞ (t + x)^−½ (t + y)⁻¹ dt, x ≥ 0, y > 0, as an inverse circular or
/// hyperbolic function.
template <class Scalar>
Scalar R_C(Scalar x, Scalar y) {
  using std::asinh, std::atan2, std::sqrt;
  if (x == y) return 1 / sqrt(x);
  const Scalar d = sqrt(y > x ? y - x : x - y);
  return (y > x ? atan2(d, sqrt(x)) : asinh(d / sqrt(y))) / d;
}

/// Returns R_F(x, y, z) = ½ ∫₀^∞ ((t + x)(t + y)(t + z))^−½ dt; x, y, z ≥ 0, at most one of them 0.
/// NaN gives NaN.
template <class Scalar>
Scalar R_F(Scalar x, Scalar y, Scalar z) {
  using std::abs, std::sqrt;
  for (;;) {
    const Scalar mean = (x + y + z) / 3;
    const Scalar X = 1 - x / mean, Y = 1 - y / mean, Z = -X - Y;
    if (!(abs(X) >= close_enough<Scalar>()) && !(abs(Y) >= close_enough<Scalar>()) &&
        !(abs(Z) >= close_enough<Scalar>())) {
      const Scalar E2 = X * Y - Z * Z, E3 = X * Y * Z;
      return (1 - E2 / 10 + E3 / 14 + E2 * E2 / 24 - 3 * E2 * E3 / 44 - 5 * E2 * E2 * E2 / 208 +
              3 * E3 * E3 / 104 + E2 * E2 * E3 / 16) /
             sqrt(mean);
    }
    const Scalar lambda = sqrt(x) * sqrt(y) + sqrt(x) * sqrt(z) + sqrt(y) * sqrt(z);
    x = (x + lambda) / 4;
    y = (y + lambda) / 4;
    z = (z + lambda) / 4;
  }
}

/// Returns R_J(x, y, z, p) = 3/2 ∫₀^∞ ((t + x)(t + y)(t + z))^−½ (t + p)⁻¹ dt; x, y, z ≥ 0, at most
/// one of them 0, p > 0. NaN gives NaN.
template <class Scalar>
Scalar R_J(Scalar x, Scalar y, Scalar z, Scalar p) {
  using std::abs, std::sqrt;
  Scalar sum = 0, quarters = 1;
  for (;;) {
    const Scalar mean = (x + y + z + 2 * p) / 5;
    const Scalar X = 1 - x / mean, Y = 1 - y / mean, Z = 1 - z / mean, P = -(X + Y + Z) / 2;
    if (!(abs(X) >= close_enough<Scalar>()) && !(abs(Y) >= close_enough<Scalar>()) &&
        !(abs(Z) >= close_enough<Scalar>()) && !(abs(P) >= close_enough<Scalar>())) {
      const Scalar XYZ = X * Y * Z, P2 = P * P;
      const Scalar E2 = X * Y + X * Z + Y * Z - 3 * P2, E3 = XYZ + 2 * E2 * P + 4 * P2 * P,
                   E4 = (2 * XYZ + E2 * P + 3 * P2 * P) * P, E5 = XYZ * P2;
      const Scalar series = 1 - 3 * E2 / 14 + E3 / 6 + 9 * E2 * E2 / 88 - 3 * E4 / 22 -
                            9 * E2 * E3 / 52 + 3 * E5 / 26 - E2 * E2 * E2 / 16 + 3 * E3 * E3 / 40 +
                            3 * E2 * E4 / 20 + 45 * E2 * E2 * E3 / 272 -
                            9 * (E3 * E4 + E2 * E5) / 68;
      return 3 * sum + quarters * series / (mean * sqrt(mean));
    }
    const Scalar a = sqrt(x), b = sqrt(y), c = sqrt(z), lambda = a * b + a * c + b * c;
    const Scalar alpha = p * (a + b + c) + a * b * c, beta = p + lambda;
    sum += quarters * R_C<Scalar>(alpha * alpha, p * beta * beta);
    quarters /= 4;
    x = (x + lambda) / 4;
    y = (y + lambda) / 4;
    z = (z + lambda) / 4;
    p = (p + lambda) / 4;
  }
}

}  // namespace stiefel::carlson
