#pragma once

#include <array>

#include "engine/dense/principal_moments_3.h"

namespace stiefel::testing {

/// The modified moments J of ModifiedSeries at order 4, 6, 8 or 10, by the formulas that Hairer and
/// Vilmart (2006) print:
///
///     1/J_i = s/I_i + d,   C = (h²/2) Σ m_i²,   H = (h²/2) Σ m_i²/I_i,
///
/// where s and d are polynomials in C and H. Moments are in units of I₁ + I₂ + I₃.
template <class Wide>
class PrintedSeries {
 public:
  using Vec = Vector3<Wide>;

  PrintedSeries(const PrincipalMoments3<Wide>& body, int order)
      : unit_(body.moments.sum()), I_(body.moments / unit_) {
    const auto S = [&](int k) { return power(0, k) + power(1, k) + power(2, k); };
    const auto X = [&](int k) { return S(-k); };
    const auto Y = [&](int a, int b) {
      return (power(0, a) + power(1, a)) * power(2, -b) +
             (power(1, a) + power(2, a)) * power(0, -b) +
             (power(2, a) + power(0, a)) * power(1, -b);
    };
    const Wide D = I_.prod(), D2 = D * D, D3 = D2 * D, D4 = D3 * D, y = Y(1, 1);
    const Wide S1 = S(1), S2 = S(2), S3 = S(3), S4 = S(4), X1 = X(1), X2 = X(2), X3 = X(3),
               X4 = X(4), Y12 = Y(1, 2), Y13 = Y(1, 3), Y21 = Y(2, 1), Y22 = Y(2, 2), Y31 = Y(3, 1);
    s_[0] = {1};
    d_[0] = {0};
    s_[1] = {S1 / (6 * D), -X1 / 3};
    d_[1] = {-1 / (3 * D), S1 / (6 * D)};
    if (order >= 6) {
      s_[2] = {(S2 / D - X1) / (30 * D), (1 - y) / (30 * D), (3 * S1 / D + 2 * X2) / 60};
      d_[2] = {-S1 / (60 * D2), X1 / (10 * D) - S2 / (60 * D2), -(9 + y) / (60 * D)};
    }
    if (order >= 8) {
      s_[3] = {(4 * D + 17 * S3 - 15 * D * y) / (2520 * D3),
               (9 * S1 + 10 * D * X2 - 6 * Y21) / (420 * D2),
               ((6 * Y12 - 100 * X1) * D + 53 * S2) / (2520 * D2),
               (15 - D * X3 - 2 * y) / (630 * D)};
      d_[3] = {(34 * D * X1 - 19 * S2) / (2520 * D3), (S3 + 2 * D * y - 85 * D) / (1260 * D3),
               (47 * S1 + 13 * Y21 - 38 * D * X2) / (2520 * D2),
               (9 * D * X1 + D * Y12 - 11 * S2) / (1260 * D2)};
    }
    if (order >= 10) {
      s_[4] = {(62 * S4 - 94 * D * Y21 + 66 * D2 * X2 + 81 * D * S1) / (45360 * D4),
               (-77 * Y31 + 75 * D * Y12 + 214 * S2 - 240 * D * X1) / (22680 * D3),
               (26 * D * Y22 + 55 * S3 + 204 * D - 50 * D2 * X3 - 59 * D * y) / (7560 * D3),
               (137 * D * X2 - D * Y13 + 3 * S1 - 69 * Y21) / (11340 * D2),
               (2 * D2 * X4 + 5 * D * Y12 - 171 * D * X1 + 159 * S2) / (45360 * D2)};
      d_[4] = {(60 * D * y - 61 * S3 - 247 * D) / (45360 * D4),
               (54 * D * S1 - S4 + 218 * D * Y21 - 426 * D2 * X2) / (45360 * D4),
               (125 * D * X1 - 5 * Y31 - 130 * S2 + 4 * D * Y12) / (7560 * D3),
               (67 * S3 - 735 * D - 15 * D * Y22 + 87 * D * y + 34 * D2 * X3) / (22680 * D3),
               (165 * S1 - D * Y13 - 9 * Y21 - 145 * D * X2) / (45360 * D2)};
    }
  }

  /// Returns 1/J for the momentum m and the step h.
  Vec inverse(const Vec& m, const Wide& h) const {
    const Vec turn = (h / unit_) * m;
    const Wide C = turn.squaredNorm() / 2, H = turn.cwiseAbs2().cwiseQuotient(I_).sum() / 2;
    const Wide s = polynomial(s_, C, H), d = polynomial(d_, C, H);
    return (s * I_.cwiseInverse().array() + d).matrix() / unit_;
  }

 private:
  /// For every k, the coefficients of Cᵏ, Cᵏ⁻¹H, …, Hᵏ.
  using Coefficients = std::array<std::array<Wide, 5>, 5>;

  Wide power(int i, int k) const {
    Wide p = 1;
    for (int j = 0; j < (k < 0 ? -k : k); ++j) p *= I_(i);
    return k < 0 ? 1 / p : p;
  }

  static Wide polynomial(const Coefficients& a, Wide C, Wide H) {
    std::array<Wide, 5> C_to = {1}, H_to = {1};
    for (std::size_t k = 1; k < 5; ++k) {
      C_to[k] = C_to[k - 1] * C;
      H_to[k] = H_to[k - 1] * H;
    }
    Wide sum = 0;
    for (std::size_t k = 0; k < 5; ++k)
      for (std::size_t j = 0; j <= k; ++j) sum += a[k][j] * C_to[k - j] * H_to[j];
    return sum;
  }

  Wide unit_;
  Vec I_;
  Coefficients s_{}, d_{};
};

}  // namespace stiefel::testing
