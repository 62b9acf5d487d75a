#pragma once

#include <array>

#include "engine/linalg/cayley_3.h"
#include "engine/linalg/power_series.h"
#include "engine/linalg/principal_moments_3.h"

namespace stiefel {

/// The moments with which the discrete rigid body of step h follows the continuous one to an even
/// order p (Hairer and Vilmart 2006):
///
///     1/J_i = s/I_i + d,   s and d even polynomials in h of degree p − 2,
///
/// constant along a motion. Their coefficients are found from the motion itself, whatever the
/// order. Seen from one of its points, at t = 0, and with τ = t², p_i = m_i(0)², a_1 = 1/I_3 −
/// 1/I_2,
///
///     m_1(t) = m_1(0) f_1(τ) + m_2(0)m_3(0) t a_1b_1(τ)   and cyclic,
///     2f_1′ = a_1 (p_2 f_2a_3b_3 + p_3 f_3a_2b_2),   b_1 + 2τb_1′ = f_2f_3 + τp_1 a_2b_2a_3b_3,
///
/// and the quaternion of the rotation from −t to t is (e, m_1(0)tc_1(τ), …),
///
///     2e′ = −Σ p_ic_if_i/I_i,   c_1 + 2τc_1′ = ef_1/I_1 + τ(p_2c_2a_3b_3/I_3 − p_3c_3a_2b_2/I_2).
///
/// This is the step h = 2t of the discrete body with moments J where
///
///     m(−t) + m(t) = (4/h) e J∘(m_1(0)tc_1, …),   m_1(t) − m_1(−t) = (4/h)(J_2 − J_3)
///     t²m_2(0)m_3(0)c_2c_3,
///
/// that is for 1/J_i = ec_i/f_i and s = e²b_1/(f_2f_3): nothing is divided by a momentum or by a
/// difference of moments. Where h is too long for its order, J is not positive.
template <class Wide>
class ModifiedSeries {
 public:
  using Vec = Vector3<Wide>;

  /// Of the motion through m.
  ModifiedSeries(const PrincipalMoments3<Wide>& body, const Vec& m, int order)
      : unit_(body.moments.sum()),
        momentum_(m.cwiseAbs().maxCoeff()),
        I_(body.moments / unit_),
        differences_(body.differences / unit_) {
    const auto terms = static_cast<std::size_t>(order / 2);
    const Vec p = momentum_ > Wide(0) ? Vec((m / momentum_).cwiseAbs2()) : Vec(Vec::Zero());
    const Vec a = differences_.cwiseQuotient(cyclic_product<Wide>(I_, I_));
    const Series zero(terms, Wide(0));
    Series e = zero;
    std::array<Series, 3> f = {zero, zero, zero}, b = f, c = f;
    e[0] = f[0][0] = f[1][0] = f[2][0] = 1;
    for (std::size_t k = 0; k < terms; ++k) {
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        b[i][k] = product_at(f[j], f[l], k);
        c[i][k] = product_at(e, f[i], k) / I_(i);
        if (k > 0) {
          b[i][k] += p(i) * a(j) * a(l) * product_at(b[j], b[l], k - 1);
          c[i][k] += p(j) * a(l) / I_(l) * product_at(c[j], b[l], k - 1) -
                     p(l) * a(j) / I_(j) * product_at(c[l], b[j], k - 1);
        }
        b[i][k] /= Wide(2 * k + 1);
        c[i][k] /= Wide(2 * k + 1);
      }
      if (k + 1 == terms) break;
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        f[i][k + 1] =
            a(i) *
            (p(j) * a(l) * product_at(f[j], b[l], k) + p(l) * a(j) * product_at(f[l], b[j], k)) /
            Wide(2 * (k + 1));
        e[k + 1] -= p(i) / I_(i) * product_at(c[i], f[i], k) / Wide(2 * (k + 1));
      }
    }
    // The smallest 1/I_i cancels least.
    int i = 0;
    I_.maxCoeff(&i);
    const int j = (i + 1) % 3, l = (i + 2) % 3;
    s_ = quotient(product(product(e, e), b[i]), product(f[j], f[l]));
    d_ = quotient(product(e, c[i]), f[i]);
    for (std::size_t k = 0; k < terms; ++k) d_[k] -= s_[k] / I_(i);
    d_[0] = 0;
  }

  /// J for the step h.
  PrincipalMoments3<Wide> operator()(const Wide& h) const {
    const Wide t = h * momentum_ / (2 * unit_), tau = t * t;
    const Wide s = polynomial(s_, tau), d = polynomial(d_, tau);
    const Vec J = (s * I_.cwiseInverse().array() + d).inverse();
    // J₂ − J₃ = J₂J₃(1/J₃ − 1/J₂) without the cancellation
    const Vec dJ = s * differences_.cwiseProduct(cyclic_product<Wide>(J, J))
                           .cwiseQuotient(cyclic_product<Wide>(I_, I_));
    return {unit_ * J, unit_ * dJ};
  }

 private:
  using Series = PowerSeries<Wide>;

  Wide unit_, momentum_;
  Vec I_, differences_;
  Series s_, d_;  ///< in τ
};

}  // namespace stiefel
