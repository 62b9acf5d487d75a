#pragma once

#include <array>

#include "engine/dense/power_series.h"
#include "engine/dense/principal_moments_3.h"
#include "engine/dense/so_3.h"

namespace stiefel {

/// The free motion of a body in three dimensions as power series in time about the state at t = 0.
/// With τ = t², p_i = m_i(0)² and a_1 = 1/I_3 − 1/I_2, cyclic,
///
///     m_1(t) = m_1(0) f_1(τ) + m_2(0)m_3(0) t a_1b_1(τ)   and cyclic,
///     2f_1′ = a_1 (p_2 f_2a_3b_3 + p_3 f_3a_2b_2),   b_1 + 2τb_1′ = f_2f_3 + τp_1 a_2b_2a_3b_3,
///
/// and the quaternion of the rotation from −t to t is (e, t m_1(0)c_1(τ), …),
///
///     2e′ = −Σ p_ic_if_i/I_i,   c_1 + 2τc_1′ = ef_1/I_1 + τ(p_2c_2a_3b_3/I_3 − p_3c_3a_2b_2/I_2):
///
/// Factors that are odd in a momentum or in t are split off, so that no coefficient needs a
/// division by them.
template <class Scalar>
struct MotionSeries {
  using Series = PowerSeries<Scalar>;
  using Vec = Vector3<Scalar>;

  std::array<Series, 3> f, b, c;
  Series e;

  /// Computes the first `terms` coefficients from the squares p of the momenta.
  MotionSeries(const PrincipalMoments3<Scalar>& body, const Vec& p, std::size_t terms)
      : e(terms, Scalar(0)) {
    const Vec& I = body.moments;
    const Vec a = body.differences.cwiseQuotient(cyclic_product<Scalar>(I, I));
    f = b = c = {e, e, e};
    e[0] = f[0][0] = f[1][0] = f[2][0] = 1;
    for (std::size_t k = 0; k < terms; ++k) {
      const Scalar odd = static_cast<Scalar>(2 * k + 1), even = static_cast<Scalar>(2 * k + 2);
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        b[i][k] = product_at(f[j], f[l], k);
        c[i][k] = product_at(e, f[i], k) / I(i);
        if (k > 0) {
          b[i][k] += p(i) * a(j) * a(l) * product_at(b[j], b[l], k - 1);
          c[i][k] += p(j) * a(l) / I(l) * product_at(c[j], b[l], k - 1) -
                     p(l) * a(j) / I(j) * product_at(c[l], b[j], k - 1);
        }
        b[i][k] /= odd;
        c[i][k] /= odd;
      }
      if (k + 1 == terms) break;
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        f[i][k + 1] =
            a(i) *
            (p(j) * a(l) * product_at(f[j], b[l], k) + p(l) * a(j) * product_at(f[l], b[j], k)) /
            even;
        e[k + 1] -= p(i) / I(i) * product_at(c[i], f[i], k) / even;
      }
    }
  }
};

}  // namespace stiefel
